#pragma once
// Put before a function of plain loops: compiled for AVX2 as well, chosen when the program starts. Contraction is off
// and sums are never reordered, so both versions give the same bits. Sanitizers run before the choice could be made, so
// they do without.

#if defined(__has_feature)
#define GNOMON_HAS_FEATURE(feature) __has_feature(feature)
#else
#define GNOMON_HAS_FEATURE(feature) 0
#endif

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__) &&     \
    !GNOMON_HAS_FEATURE(thread_sanitizer) && !GNOMON_HAS_FEATURE(address_sanitizer)
#define GNOMON_VECTOR_CLONES [[gnu::target_clones("avx2", "default")]]
#else
#define GNOMON_VECTOR_CLONES
#endif
