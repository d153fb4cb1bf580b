/* Large pages for memory that is read here and there: a look into it then seldom waits for its page to be
 * found. */
#ifndef FOVEAD_RENDERER_LARGE_PAGES_H
#define FOVEAD_RENDERER_LARGE_PAGES_H

#include <stddef.h>
#include <stdint.h>
#include <sys/mman.h>
#include <unistd.h>

/* Ask for them, for memory that was allocated and not touched yet. A system that has none changes nothing. */
static inline void rnd_use_large_pages(void *memory, size_t bytes)
{
    const uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE),
                    first = ((uintptr_t)memory + page - 1) & ~(page - 1),
                    end = ((uintptr_t)memory + bytes) & ~(page - 1);
    if (memory && end > first) madvise((void *)first, end - first, MADV_HUGEPAGE);
}

#endif
