#pragma once

/// \file One function body for each instruction set, chosen when the library is loaded. Packaged binaries are built
/// for the baseline of their architecture; hot loops need more.
///
/// A function of this kind that other files call stands in namespace tanor_kernels. gcc exports it whatever its
/// visibility, and libtanor.map exports namespace tanor alone.

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define TANOR_EACH_INSTRUCTION_SET [[gnu::target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")]]
#else
#define TANOR_EACH_INSTRUCTION_SET
#endif
