/* Large pages for memory that is read at random: addresses are then translated faster. */
#ifndef FOVEAD_RENDERER_LARGE_PAGES_H
#define FOVEAD_RENDERER_LARGE_PAGES_H

#include <stddef.h>
#include <stdint.h>
#include <sys/mman.h>
#include <unistd.h>

/* Ask for large pages for memory that is allocated and not touched yet. A system without them changes
 * nothing. */
static inline void rnd_use_large_pages(void *memory, size_t bytes)
{
    const uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE),
                    first = ((uintptr_t)memory + page - 1) & ~(page - 1),
                    end = ((uintptr_t)memory + bytes) & ~(page - 1);
    if (memory && end > first) madvise((void *)first, end - first, MADV_HUGEPAGE);
}

#endif
