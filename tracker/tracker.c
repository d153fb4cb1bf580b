/* The tracker's front: the table of sources, how one is chosen, and what every caller goes through. */
#include "tracker.h"

#include "error.h"
#include "source/source.h"

#include <cglm/cglm.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const struct trk_source_type *const types[] = {
    &trk_replay,
    &trk_synthetic,
    &trk_pointer,
};
enum { TYPES = sizeof types / sizeof *types };

bool trk_world_direction(const struct trk_sample *sample, float out_direction[3])
{
    if (!(sample->valid & TRK_DIRECTION)) return false;
    vec3 direction;
    memcpy(direction, sample->direction, sizeof direction);
    if (sample->valid & TRK_HEAD) {
        versor head; /* a copy: cglm's is aligned */
        memcpy(head, &sample->head[3], sizeof head);
        glm_quat_rotatev(head, direction, direction);
    }
    glm_vec3_normalize_to(direction, out_direction);
    return true;
}

/* The first device that opens; without one the recording, and a word on why. */
static struct trk_source *open_auto(const struct trk_source_options *options, char out_error[TRK_ERROR_SIZE])
{
    for (int i = 0; i < TYPES; i++) {
        struct trk_source *device = types[i]->is_device ? types[i]->open(NULL, options, out_error) : NULL;
        if (device) return device;
    }
    if (!options->fallback_log) {
        trk_fail(out_error,
                 "gaze source 'auto': no eye tracker found, expected one or a recording to replay");
        return NULL;
    }
    struct trk_source *source = trk_replay.open(options->fallback_log, options, out_error);
    if (!source) return NULL;
    size_t length = strlen(source->description);
    snprintf(source->description + length, sizeof source->description - length, " (no eye tracker found)");
    return source;
}

struct trk_source *trk_open(const struct trk_source_options *options, char out_error[TRK_ERROR_SIZE])
{
    size_t length = strcspn(options->spec, ":");
    const char *argument = options->spec[length] ? options->spec + length + 1 : NULL;
    if (strcmp(options->spec, "auto") == 0) return open_auto(options, out_error);
    for (int i = 0; i < TYPES; i++)
        if (strlen(types[i]->name) == length && strncmp(types[i]->name, options->spec, length) == 0)
            return types[i]->open(argument, options, out_error);

    char expected[256] = "auto";
    for (int i = 0; i < TYPES; i++) {
        size_t end = strlen(expected);
        snprintf(expected + end, sizeof expected - end, ", %s", types[i]->usage);
    }
    trk_fail(out_error, "unknown gaze source '%.100s', expected one of %s", options->spec, expected);
    return NULL;
}

void trk_close(struct trk_source *source)
{
    if (source) source->type->close(source);
}

const char *trk_describe(const struct trk_source *source)
{
    return source->description;
}

enum trk_result trk_read(struct trk_source *source, uint64_t until_ns, struct trk_sample *out_sample,
                         char out_error[TRK_ERROR_SIZE])
{
    return source->type->read(source, until_ns, out_sample, out_error);
}

bool trk_push(struct trk_source *source, const float direction[3], uint64_t time_ns)
{
    if (!source->type->push) return false;
    /* In double: the squares of the largest and smallest floats still count. */
    double x = direction[0], y = direction[1], z = direction[2], length = sqrt(x * x + y * y + z * z);
    if (!isfinite(length) || length == 0) return false;
    source->type->push(source, (float[3]){(float)(x / length), (float)(y / length), (float)(z / length)},
                       time_ns);
    return true;
}

void trk_interrupt(struct trk_source *source)
{
    pthread_mutex_lock(&source->lock);
    source->interrupted = true;
    pthread_cond_signal(&source->changed);
    pthread_mutex_unlock(&source->lock);
}
