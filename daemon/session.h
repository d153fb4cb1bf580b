/* session: one client, from Hello to the end. It takes the messages that came and gives those that should go;
 * what wraps and carries them is its owner's matter. No message waits in it packed: a tile is read and
 * encoded at the moment the client can take it, so the newest always wins and a slow client is just sent
 * less.
 *
 * All sessions belong to the loop's thread. */
#ifndef FOVEAD_DAEMON_SESSION_H
#define FOVEAD_DAEMON_SESSION_H

#include "client.h"

struct dmn_client *dmn_session_create(const struct dmn_client_options *options);
void dmn_session_destroy(struct dmn_client *client); /* accepts NULL */

/* May the client's next message be taken? Not while its Hello waits for the turn of its token. */
bool dmn_session_is_ready(const struct dmn_client *client);
/* Take a message from the client over, which must be ready. False with a line in out_error if the client must
 * be dropped. */
bool dmn_session_take(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE]);
/* Call it DMN_CHECKS_A_SECOND times per second, each time after the client's messages were taken; partial
 * says that one has begun and not ended. The client may be ready after it. False with a line in out_error if
 * it must be dropped: its token is wrong, or it is overdue with its Hello or the rest of a message. */
enum { DMN_CHECKS_A_SECOND = 4 };
bool dmn_session_check(struct dmn_client *client, bool partial, char out_error[PRO_ERROR_SIZE]);

/* Send nothing more but Bye. */
void dmn_session_end(struct dmn_client *client);

/* Statistics are due. */
void dmn_session_stats(struct dmn_client *client);
/* A job that this client asked for is done, or cannot be. */
void dmn_session_done(struct dmn_client *client, const struct dmn_job *job);

#endif
