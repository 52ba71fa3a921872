#pragma once

// TETRAKIS_FOR_AVX2_TOO marks functions that are compiled twice, for AVX2 and for any processor; the loader chooses.
// Both versions of a function give the same bits, because neither fuses products and sums. ThreadSanitizer builds have
// one version: the loader would choose before the sanitizer's runtime is ready.
#if defined(__linux__) && defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_THREAD__)
#    define TETRAKIS_FOR_AVX2_TOO __attribute__((target_clones("avx2", "default")))
#else
#    define TETRAKIS_FOR_AVX2_TOO
#endif
