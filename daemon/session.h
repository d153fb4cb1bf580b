/* session: one client, from Hello to the end. It takes the client's messages and gives those that are to be
 * sent (send.h); its owner wraps and carries them. For the loop's thread alone. */
#ifndef FOVEAD_DAEMON_SESSION_H
#define FOVEAD_DAEMON_SESSION_H

#include "client.h"

struct dmn_client *dmn_session_create(const struct dmn_client_options *options);
void dmn_session_destroy(struct dmn_client *client); /* accepts NULL */

/* May the client's next message be taken? Not while the token of its Hello waits to be checked. */
bool dmn_session_is_ready(const struct dmn_client *client);
/* Take a message of the client, which must be ready, and own it. False with a line in out_error if the client
 * must be dropped. */
bool dmn_session_take(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE]);
/* Call this DMN_CHECKS_A_SECOND times per second, after the client's messages were taken. partial: a message
 * has begun and not ended. The client may then be ready. False with a line in out_error if it must be
 * dropped: its token is wrong, or its Hello or the rest of a message is overdue. */
enum { DMN_CHECKS_A_SECOND = 4 };
bool dmn_session_check(struct dmn_client *client, bool partial, char out_error[PRO_ERROR_SIZE]);

/* Send only Bye from now on. */
void dmn_session_end(struct dmn_client *client);

/* Statistics are due. */
void dmn_session_stats(struct dmn_client *client);
/* A job that this client asked for is done, or cannot be. */
void dmn_session_done(struct dmn_client *client, const struct dmn_job *job);

#endif
