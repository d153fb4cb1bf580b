/* bids_sidecar: the metadata of a table in JSON files beside and above it. */
#ifndef FOVEAD_TRACKER_LOG_BIDS_SIDECAR_H
#define FOVEAD_TRACKER_LOG_BIDS_SIDECAR_H

#include "log/reading.h"

#include <jansson.h>

/* Where metadata was searched for, and how many metadata files were found. */
struct trk_bids_places {
    char top[128]; /* the highest folder searched; the search began in the table's folder */
    size_t files;
};

/* Collect the metadata that applies to the log. suffix is "physio" or "events"; NULL stands for the suffix of
 * the log's own name. A file applies if the log's name has all the file's entities (sub-01, task-view, ...).
 * The search goes from the log's folder up to the root of the dataset. If several files have the same key,
 * the deepest file counts; in one folder, the file with most entities. Returns a new reference to an object,
 * which is empty if no file applies, or NULL with a message if a file cannot be read. The log lists these
 * files among its sources. */
json_t *trk_bids_inherit(struct trk_reading *reading, const char *suffix, struct trk_bids_places *out_places,
                         char out_error[TRK_ERROR_SIZE]);

/* The suffix of a log that is called NAME_SUFFIX.tsv or .tsv.gz, in at most 32 bytes; "" for any other name.
 */
void trk_bids_suffix(const char *path, char out_suffix[32]);

#endif
