#pragma once

/// TANOR_API marks what the shared library shows; everything else has hidden visibility. TANOR_LOCAL hides a class
/// nested in a shown one.
#if defined(_WIN32)
#define TANOR_API
#define TANOR_LOCAL
#else
#define TANOR_API __attribute__((visibility("default")))
#define TANOR_LOCAL __attribute__((visibility("hidden")))
#endif
