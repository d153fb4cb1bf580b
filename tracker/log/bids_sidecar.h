/* bids_sidecar: the metadata of a table in JSON files beside and above it. */
#ifndef FOVEAD_TRACKER_LOG_BIDS_SIDECAR_H
#define FOVEAD_TRACKER_LOG_BIDS_SIDECAR_H

#include "log/reading.h"

#include <jansson.h>

/* Where metadata was searched for, and how many files of it there were. */
struct trk_bids_places {
    char top[128]; /* the highest folder; that of the table is the lowest */
    size_t files;
};

/* All metadata of that suffix ("physio", "events"; NULL: the last part of the log's own name) for the log:
 * the files whose entities (sub-01, task-view, ...) are all the log's too, from its own folder up to the root
 * of the dataset; of several that have a key, the one counts that is deeper, or has more entities. An object,
 * empty if there is none; a new reference. NULL with a message if a file cannot be read. The files are noted
 * as the log's. */
json_t *trk_bids_inherit(struct trk_reading *reading, const char *suffix, struct trk_bids_places *out_places,
                         char out_error[TRK_ERROR_SIZE]);

/* The suffix of the log's name, of a NAME_SUFFIX.tsv or .tsv.gz, in at most 32 bytes; "" if it has another.
 */
void trk_bids_suffix(const char *path, char out_suffix[32]);

#endif
