/* The recording of gaze: its file, the tracker's recorder, and what a client is told. */
#include <stdio.h>
#include <string.h>

#include "file.h"
#include "recording.h"

void dmn_recording_init(struct dmn_recording *recording)
{
    *recording = (struct dmn_recording){0};
    pthread_mutex_init(&recording->lock, NULL);
}

void dmn_recording_finish(struct dmn_recording *recording)
{
    trk_recorder_close(recording->recorder, NULL);
    pthread_mutex_destroy(&recording->lock);
}

bool dmn_recording_begin(struct dmn_recording *recording, const char *path, bool replace,
                         char out_text[DMN_TEXT_SIZE])
{
    char error[TRK_ERROR_SIZE];
    struct trk_recorder *recorder = NULL;
    struct dmn_file file;
    int fd = -1;

    if (recording->recorder) {
        snprintf(out_text, DMN_TEXT_SIZE, "gaze is being recorded to %.900s", recording->path);
        return false;
    }
    if (dmn_file_begin(&file, path, 0600, replace, error)) {
        trk_recorder_print_head(file.file);
        fd = dmn_file_keep(&file, error);
    }
    if (fd < 0 || !(recorder = trk_recorder_start(fd, path, error))) {
        snprintf(out_text, DMN_TEXT_SIZE, "%s", error);
        return false;
    }
    pthread_mutex_lock(&recording->lock);
    recording->recorder = recorder;
    snprintf(recording->path, sizeof(recording->path), "%s", path);
    pthread_mutex_unlock(&recording->lock);
    snprintf(out_text, DMN_TEXT_SIZE, "recording to %.900s", path);
    return true;
}

bool dmn_recording_end(struct dmn_recording *recording, char out_text[DMN_TEXT_SIZE])
{
    struct trk_recorder_status status;
    struct trk_recorder *recorder;
    char path[DMN_TEXT_SIZE];
    size_t length;
    bool good;

    pthread_mutex_lock(&recording->lock);
    recorder = recording->recorder;
    recording->recorder = NULL;
    memcpy(path, recording->path, sizeof(path));
    recording->path[0] = '\0';
    pthread_mutex_unlock(&recording->lock);
    if (!recorder) {
        snprintf(out_text, DMN_TEXT_SIZE, "gaze is not being recorded");
        return false;
    }
    good = trk_recorder_close(recorder, &status);
    length = (size_t)snprintf(out_text, DMN_TEXT_SIZE, "recorded %llu samples to %.300s",
                              (unsigned long long)status.written, path);
    if (status.refused)
        length += (size_t)snprintf(out_text + length, DMN_TEXT_SIZE - length, ", %llu refused",
                                   (unsigned long long)status.refused);
    if (status.lost)
        snprintf(out_text + length, DMN_TEXT_SIZE - length, ", %llu lost: %s",
                 (unsigned long long)status.lost, status.error);
    return good;
}

void dmn_recording_append(struct dmn_recording *recording, const struct trk_sample *sample)
{
    pthread_mutex_lock(&recording->lock);
    if (recording->recorder) trk_recorder_append(recording->recorder, sample);
    pthread_mutex_unlock(&recording->lock);
}

void dmn_recording_tell(struct dmn_recording *recording, char out_path[DMN_TEXT_SIZE],
                        struct trk_recorder_status *out_status)
{
    *out_status = (struct trk_recorder_status){0};
    pthread_mutex_lock(&recording->lock);
    memcpy(out_path, recording->path, sizeof(recording->path));
    if (recording->recorder) trk_recorder_get_status(recording->recorder, out_status);
    pthread_mutex_unlock(&recording->lock);
}
