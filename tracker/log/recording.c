/* Several recordings in one table, and the choice of one by an option. */
#include "log/recording.h"

#include "error.h"

#include <string.h>
#include <strings.h>

static bool is_same(const struct trk_recording *a, const struct trk_recording *b)
{
    return strcmp(a->participant, b->participant) == 0 && strcmp(a->name, b->name) == 0;
}

/* The text that identifies a recording: its name, with its participant if the name is not unique. */
static void label(const struct trk_reading *reading, const struct trk_recording *recording,
                  char out_label[2 * TRK_RECORDING_SIZE])
{
    int same = 0;
    for (size_t i = 0; i < reading->recording_count; i++)
        same += strcmp(reading->recordings[i].name, recording->name) == 0;
    bool is_both = *recording->name && *recording->participant && same > 1;
    snprintf(out_label, 2 * TRK_RECORDING_SIZE, "%s%s%s",
             is_both || !*recording->name ? recording->participant : "", is_both ? "/" : "", recording->name);
}

/* Does the option name the recording? It may be the recording's name, the participant, or PARTICIPANT/NAME.
 */
static bool is_wanted(const struct trk_recording *recording, const char *option)
{
    size_t length = strlen(recording->participant);
    if (strcasecmp(option, recording->name) == 0 || strcasecmp(option, recording->participant) == 0)
        return true;
    return strncasecmp(option, recording->participant, length) == 0 && option[length] == '/' &&
           strcasecmp(option + length + 1, recording->name) == 0;
}

/* Copy a field; "" if the row has none. */
static void take(char out[TRK_RECORDING_SIZE], const char *field_or_null)
{
    const char *field = field_or_null ? field_or_null : "";
    snprintf(out, TRK_RECORDING_SIZE, "%s", strcasecmp(field, "n/a") == 0 ? "" : field);
}

enum trk_recording_row trk_recording_of_row(struct trk_reading *reading, const char *participant,
                                            const char *name)
{
    const char *option = reading->options->recording;
    struct trk_recording recording;
    take(recording.participant, participant);
    take(recording.name, name);
    if (!*recording.participant && !*recording.name)
        return option ? TRK_RECORDING_OTHER : TRK_RECORDING_WANTED;
    size_t i = 0;
    while (i < reading->recording_count && !is_same(&reading->recordings[i], &recording)) i++;
    if (i == TRK_MAX_RECORDINGS) {
        reading->has_more_recordings = true;
    } else if (i == reading->recording_count) {
        reading->recordings[reading->recording_count++] = recording;
        reading->recordings_wanted += !option || is_wanted(&recording, option);
    }
    if (option && !is_wanted(&recording, option)) return TRK_RECORDING_OTHER;
    return reading->recordings_wanted > 1 || i == TRK_MAX_RECORDINGS ? TRK_RECORDING_SEVERAL
                                                                     : TRK_RECORDING_WANTED;
}

/* Write "A, B, C": the recordings that match the option, or all of them. */
static void list(const struct trk_reading *reading, bool of_option, char *out_text, size_t size)
{
    const char *option = reading->options->recording;
    size_t used = 0, total = reading->recording_count;
    out_text[0] = '\0';
    for (size_t i = 0, listed = 0; i < total; i++) {
        char name[2 * TRK_RECORDING_SIZE];
        if (of_option && option && !is_wanted(&reading->recordings[i], option)) continue;
        label(reading, &reading->recordings[i], name);
        if (used + strlen(name) + 24 > size) {
            snprintf(out_text + used, size - used, " and more");
            return;
        }
        used += (size_t)snprintf(out_text + used, size - used, "%s%s", listed++ ? ", " : "", name);
    }
    if (reading->has_more_recordings) snprintf(out_text + used, size - used, " and more");
}

bool trk_recording_is_met(const struct trk_reading *reading, bool has_columns, char out_error[TRK_ERROR_SIZE])
{
    const char *option = reading->options->recording;
    char names[TRK_ERROR_SIZE / 2];
    const size_t wanted = reading->recordings_wanted;
    if (option && !has_columns)
        return trk_fail(out_error, "%s: has no column that tells recordings apart, expected no --recording",
                        reading->lines.path);
    if (option && reading->has_more_recordings)
        return trk_fail(out_error, "%s: holds more than %d recordings, expected fewer", reading->lines.path,
                        TRK_MAX_RECORDINGS);
    if (option && wanted == 0) {
        list(reading, false, names, sizeof names);
        return trk_fail(out_error, "%.150s: has no recording '%.40s', expected one of %s",
                        reading->lines.path, option, names);
    }
    if (wanted <= 1 && !reading->has_more_recordings) return true;
    list(reading, true, names, sizeof names);
    return trk_fail(out_error,
                    "%.100s: holds several recordings (%s), expected a choice of one: foveactl gaze convert "
                    "--recording NAME",
                    reading->lines.path, names);
}
