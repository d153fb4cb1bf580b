/* Files that people mistake for gaze logs, and the messages about them. */
#include "log/foreign.h"

#include "log/table.h"

#include <string.h>

static const struct {
    size_t at, size;
    const char *bytes, *says;
} magics[] = {
    {0, 11, "SR_RESEARCH", "an EyeLink EDF, expected it as text: turn it into .asc with edf2asc"},
    {0, 4, "PK\3\4",
     "a zip archive (or an .xlsx), expected the log that is in it, unpacked, or as text or gzip"},
    {0, 4, "PK\5\6", "an empty zip archive, expected a gaze log"},
    {0, 6,
     "\xfd"
     "7zXZ\0",
     "xz data, expected it unpacked, or as gzip"},
    {0, 3, "BZh", "bzip2 data, expected it unpacked, or as gzip"},
    {0, 4, "\x28\xb5\x2f\xfd", "zstd data, expected it unpacked, or as gzip"},
    {0, 4, "\x04\x22\x4d\x18", "lz4 data, expected it unpacked, or as gzip"},
    {0, 6, "7z\xbc\xaf\x27\x1c", "a 7z archive, expected the log that is in it, unpacked or as gzip"},
    {0, 4, "Rar!", "a rar archive, expected the log that is in it, unpacked or as gzip"},
    {257, 5, "ustar", "a tar archive, expected the log that is in it, unpacked or as gzip"},
    {0, 8, "\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1",
     "an Excel workbook (.xls), expected it exported as text (.csv)"},
    {0, 8, "\x89HDF\r\n\x1a\n", "an HDF5 file, expected its table of gaze as text (.csv)"},
    {0, 10, "MATLAB 5.0", "a MATLAB file, expected its table of gaze as text (.csv)"},
    {0, 15, "SQLite format 3", "an SQLite database, expected its table of gaze as text (.csv)"},
    {0, 4, "PAR1", "a Parquet file, expected it as text (.csv)"},
    {0, 6, "ARROW1", "an Arrow file, expected it as text (.csv)"},
    {0, 6, "\x93NUMPY", "a NumPy array, expected it as text (.csv)"},
    {0, 5, "%PDF-", "a PDF, expected a gaze log"},
    {0, 4, "\x89PNG", "a PNG picture, expected a gaze log"},
    {0, 2, "\xff\xfe", "text in UTF-16, expected it in UTF-8"},
    {0, 2, "\xfe\xff", "text in UTF-16, expected it in UTF-8"},
};

bool trk_check_magic(const struct trk_reading *reading, size_t size, char out_error[TRK_ERROR_SIZE])
{
    for (size_t i = 0; i < sizeof magics / sizeof *magics; i++)
        if (magics[i].at + magics[i].size <= size &&
            memcmp(reading->head + magics[i].at, magics[i].bytes, magics[i].size) == 0)
            return trk_lines_fail(&reading->lines, out_error, "is %s", magics[i].says);
    return true;
}

/* Files that usually lie beside a gaze log or have its name, but hold no gaze that can be used. */
static const struct {
    const char *columns[4];
    const char *says;
} namesakes[] = {
    {{"section id", "gaze detected on surface", "gaze position on surface x"},
     "gaze on a mapped picture, which has no direction; expected the gaze.csv of the raw data export"},
    {{"section id", "recording id", "gaze position in reference image x"},
     "gaze on a reference image, which has no direction; expected the gaze.csv of the raw data export"},
    {{"section id", "blink id", "start timestamp"}, "Pupil Cloud's blinks, expected its gaze.csv"},
    {{"section id", "fixation id", "start timestamp"}, "Pupil Cloud's fixations, expected its gaze.csv"},
    {{"section id", "gyro x", "acceleration x"}, "Pupil Cloud's IMU, expected its gaze.csv"},
    {{"start_timestamp", "duration", "dispersion"},
     "Pupil Player's fixations, expected its gaze_positions.csv"},
    {{"pupil_timestamp", "eye_id"}, "Pupil Player's pupils, expected its gaze_positions.csv"},
    {{"onset", "duration"}, "BIDS events, expected the _physio.tsv.gz of the gaze"},
};

bool trk_check_namesakes(const struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    for (size_t i = 0; i < sizeof namesakes / sizeof *namesakes; i++)
        if (trk_header_has(&reading->header, namesakes[i].columns))
            return trk_lines_fail(&reading->lines, out_error, "is %s", namesakes[i].says);
    return true;
}
