#pragma once

/// TANOR_API marks what the shared library shows; everything else has hidden visibility.
#if defined(_WIN32)
#  define TANOR_API
#else
#  define TANOR_API __attribute__((visibility("default")))
#endif
