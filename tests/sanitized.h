/* SANITIZED: is this a build with a sanitizer? Sanitizers check what code does, not how often. So tests that
 * draw or trace many times for a mean do so less often there, with a wider tolerance. */
#ifndef FOVEAD_TESTS_SANITIZED_H
#define FOVEAD_TESTS_SANITIZED_H

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SANITIZED 1
#endif
#endif
#ifndef SANITIZED
#define SANITIZED 0
#endif

#endif
