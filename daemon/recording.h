/* recording: the file that gaze samples are recorded to, at a client's or the user's request. */
#ifndef FOVEAD_DAEMON_RECORDING_H
#define FOVEAD_DAEMON_RECORDING_H

#include <pthread.h>

#include "tracker.h"

enum { DMN_TEXT_SIZE = 1024 }; /* of a line that says what was done, or why not */

/* Any thread may call any function; one thread at a time begins and ends recordings, and waits for the disk.
 */
struct dmn_recording {
    pthread_mutex_t lock;          /* of all that follows */
    struct trk_recorder *recorder; /* NULL: nothing is being recorded */
    char path[DMN_TEXT_SIZE];
};

void dmn_recording_init(struct dmn_recording *recording);
/* Ends the recording, if there is one. */
void dmn_recording_finish(struct dmn_recording *recording);

/* Record to a file from now on. replace: a file of that name may be replaced. out_text says what was done, or
 * why not. */
bool dmn_recording_begin(struct dmn_recording *recording, const char *path, bool replace,
                         char out_text[DMN_TEXT_SIZE]);
/* False if nothing was being recorded, or if samples were lost. out_text says how many there are. */
bool dmn_recording_end(struct dmn_recording *recording, char out_text[DMN_TEXT_SIZE]);

/* Record a sample, if anything is being recorded. Does not wait for the disk. */
void dmn_recording_append(struct dmn_recording *recording, const struct trk_sample *sample);

/* The path of the file, "" if nothing is being recorded, and the recorder's status. */
void dmn_recording_tell(struct dmn_recording *recording, char out_path[DMN_TEXT_SIZE],
                        struct trk_recorder_status *out_status);

#endif
