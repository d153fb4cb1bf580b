/* Charts by gnuplot. It does not notice when its output cannot be written, so it draws into memory. */
#include "chart.h"

#include <errno.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

bool dmn_chart_begin(struct dmn_chart *chart, char out_error[DMN_FILE_ERROR_SIZE])
{
    char command[96];

    chart->drawn = memfd_create("chart", MFD_CLOEXEC);
    snprintf(command, sizeof(command), "gnuplot 2>/dev/null >/proc/%ld/fd/%d", (long)getpid(), chart->drawn);
    chart->commands = chart->drawn < 0 ? NULL : popen(command, "w");
    if (chart->commands) return true;
    snprintf(out_error, DMN_FILE_ERROR_SIZE, "gnuplot: %s", strerror(errno));
    if (chart->drawn >= 0) close(chart->drawn);
    return false;
}

/* Does the chart have the end that a whole one has? */
static bool is_whole(int drawn, const char *path)
{
    static const char PNG_END[] = "IEND\xae\x42\x60\x82", SVG_END[] = "</svg>";
    size_t length = strlen(path);
    const char *end = length > 4 && !strcmp(path + length - 4, ".png") ? PNG_END : SVG_END;
    char last[12] = "";
    off_t size = lseek(drawn, 0, SEEK_END);

    return size > (off_t)sizeof(last) && pread(drawn, last, sizeof(last), size - (off_t)sizeof(last)) > 0 &&
           memmem(last, sizeof(last), end, strlen(end));
}

static bool copy(int drawn, const char *path, mode_t mode, char out_error[DMN_FILE_ERROR_SIZE])
{
    char bytes[65536];
    struct dmn_file file;
    ssize_t count;
    off_t at = 0;

    if (!dmn_file_begin(&file, path, mode, true, out_error)) return false;
    for (; (count = pread(drawn, bytes, sizeof(bytes), at)) > 0; at += count)
        fwrite(bytes, 1, (size_t)count, file.file);
    return dmn_file_end(&file, out_error);
}

bool dmn_chart_end(struct dmn_chart *chart, const char *path, mode_t mode,
                   char out_error[DMN_FILE_ERROR_SIZE])
{
    int status = pclose(chart->commands);
    bool good = false;

    if (WIFEXITED(status) && WEXITSTATUS(status) == 127) /* as the shell says that it found no such program */
        snprintf(out_error, DMN_FILE_ERROR_SIZE, "gnuplot is missing: apt-get install gnuplot-nox");
    else if (status || !is_whole(chart->drawn, path))
        snprintf(out_error, DMN_FILE_ERROR_SIZE, "%.300s: gnuplot could not draw it", path);
    else
        good = copy(chart->drawn, path, mode, out_error);
    close(chart->drawn);
    return good;
}
