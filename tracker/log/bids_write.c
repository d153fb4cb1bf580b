/* Writing BIDS eye tracking: NAME.tsv.gz without a header, and its sidecar NAME.json.
 *
 * One file holds one gaze. This writer writes the combined gaze, which is "cyclopean" unless only one eye was
 * recorded. The coordinate system is gaze-in-world if there is a head pose, else eye-in-head. x_coordinate
 * and y_coordinate are degrees to the right of and above straight ahead (up applied after right), n/a where
 * the gaze was lost. timestamp is in seconds of the tracker's clock. pupil_size, where there is any, is the
 * mean of the eyes' diameters in mm. Head pose, origins and the gaze of each eye are not written; the
 * project's own format keeps them. */
#include "log/formats.h"

#include "error.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

static double pupil_mm(const struct trk_sample *sample)
{
    double sum = 0;
    int count = 0;
    for (int eye = 0; eye < 2; eye++)
        if (sample->valid & TRK_LEFT_PUPIL << 4 * eye) {
            sum += (double)sample->eye[eye].pupil_mm;
            count++;
        }
    return count ? sum / count : NAN;
}

/* zlib writes directly to the file descriptor. That is safe because the buffer of `table` is empty. */
static bool write_rows(FILE *table, const struct trk_log *log, bool with_pupil)
{
    int fd = dup(fileno(table));
    gzFile file = fd < 0 ? NULL : gzdopen(fd, "wb");
    bool ok = file != NULL;
    if (!file && fd >= 0) close(fd);
    for (size_t i = 0; i < log->count && ok; i++) {
        struct trk_sample sample;
        float d[3];
        trk_log_sample(log, i, &sample);
        ok = gzprintf(file, "%llu.%09llu", (unsigned long long)(sample.device_ns / 1000000000),
                      (unsigned long long)(sample.device_ns % 1000000000)) > 0;
        if (trk_world_direction(&sample, d))
            ok &= gzprintf(file, "\t%.5f\t%.5f", atan2((double)d[0], (double)-d[2]) * 180 / M_PI,
                           asin(fmin(fmax((double)d[1], -1), 1)) * 180 / M_PI) > 0;
        else
            ok &= gzputs(file, "\tn/a\tn/a") > 0;
        double pupil = pupil_mm(&sample);
        if (with_pupil) ok &= (isnan(pupil) ? gzputs(file, "\tn/a") : gzprintf(file, "\t%.4f", pupil)) > 0;
        ok &= gzputc(file, '\n') == '\n';
    }
    return file && gzclose(file) == Z_OK && ok;
}

/* Which eye the gaze came from, if only one was recorded. */
static const char *recorded_eye(uint32_t seen)
{
    bool left = seen & TRK_LEFT_DIRECTION, right = seen & TRK_RIGHT_DIRECTION;
    return left == right ? "cyclopean" : left ? "left" : "right";
}

static bool write_sidecar(FILE *file, const struct trk_log *log, uint32_t seen, bool with_pupil)
{
    struct trk_sample first;
    struct trk_rate rate;
    trk_log_sample(log, 0, &first);
    trk_log_rate(log, &rate);
    bool in_world = first.valid & TRK_HEAD;
    json_t *root =
        json_pack("{s:s, s:s, s:s, s:f, s:f, s:s, s:[s,s,s], s:{s:s, s:s}, s:{s:s, s:s}, s:{s:s, s:s}}",
                  "PhysioType", "eyetrack", "RecordedEye", recorded_eye(seen), "SampleCoordinateSystem",
                  in_world ? "gaze-in-world" : "eye-in-head", "SamplingFrequency", round(rate.hz * 1e3) / 1e3,
                  "StartTime", (double)first.device_ns / 1e9, "Description",
                  "Converted by fovead from a log of its own or another format.", "Columns", "timestamp",
                  "x_coordinate", "y_coordinate", "timestamp", "Description",
                  "time of the sample on the tracker's clock", "Units", "s", "x_coordinate", "Description",
                  "gaze to the right of straight ahead (azimuth)", "Units", "deg", "y_coordinate",
                  "Description", "gaze up from the horizon (elevation)", "Units", "deg");
    if (!root) return false;
    if (with_pupil) {
        json_array_append_new(json_object_get(root, "Columns"), json_string("pupil_size"));
        json_object_set_new(
            root, "pupil_size",
            json_pack("{s:s, s:s}", "Description", "pupil diameter, mean of the eyes", "Units", "mm"));
    }
    bool ok = json_dumpf(root, file, JSON_INDENT(2)) == 0;
    json_decref(root);
    return ok;
}

bool trk_log_print_bids(const struct trk_log *log, FILE *table, FILE *sidecar, char out_error[TRK_ERROR_SIZE])
{
    const uint32_t seen = trk_log_seen(log);
    const bool with_pupil = seen & (TRK_LEFT_PUPIL | TRK_RIGHT_PUPIL);
    if (log->count == 0) return trk_fail(out_error, "no samples to write, expected at least one");
    errno = 0;
    if (write_sidecar(sidecar, log, seen, with_pupil) && write_rows(table, log, with_pupil)) return true;
    return trk_fail(out_error, "cannot be written: %s", errno ? strerror(errno) : "no memory");
}
