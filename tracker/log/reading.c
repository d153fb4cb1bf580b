/* What all readers share: noting assumptions, and noting which files were read. */
#include "log/reading.h"

#include "error.h"

#include <string.h>
#include <sys/stat.h>

void trk_assume(struct trk_reading *reading, const char *format, ...)
{
    char *assumed = reading->log->assumed;
    size_t length = strlen(assumed);
    va_list arguments;
    if (length >= TRK_ASSUMED_SIZE - 3) return;
    if (length) length += (size_t)sprintf(assumed + length, "; ");
    va_start(arguments, format);
    vsnprintf(assumed + length, TRK_ASSUMED_SIZE - length, format, arguments);
    va_end(arguments);
    trk_make_printable(assumed + length); /* the text may hold column names from the file */
}

void trk_note_source(struct trk_log *log, int fd)
{
    struct stat status;
    if (fstat(fd, &status) != 0 || log->source_count == TRK_MAX_SOURCES) return;
    log->sources[log->source_count].device = status.st_dev;
    log->sources[log->source_count++].inode = status.st_ino;
}
