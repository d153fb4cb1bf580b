/* Does what waits for the disk, in a thread of its own. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

#include "image.h"
#include "saver.h"

struct dmn_saver {
    struct rnd_render *render;
    struct dmn_gaze *gaze;
    void (*wake)(void *context);
    void *context;
    pthread_t thread;
    bool started;

    pthread_mutex_t lock; /* of all that follows */
    pthread_cond_t changed;
    bool stop;
    /* A ring: first are the ones that are done, then those that wait. */
    struct dmn_save save[DMN_SAVES];
    unsigned first, done, count;
};

static void act(const struct dmn_saver *saver, struct dmn_save *save)
{
    char error[RND_ERROR_SIZE];

    switch (save->what) {
    case DMN_SAVE_FILM:
        save->good = dmn_image_save(saver->render, save->path, error);
        snprintf(save->text, sizeof(save->text), save->good ? "wrote %.900s" : "%.900s",
                 save->good ? save->path : error);
        break;
    case DMN_SAVE_GAZE:
        save->good = dmn_gaze_record(saver->gaze, save->path, save->replace, save->text);
        break;
    case DMN_SAVE_GAZE_END:
        save->good = dmn_gaze_record(saver->gaze, NULL, false, save->text);
        break;
    case DMN_SAVE_RECENTRE:
        save->good = dmn_gaze_recentre(saver->gaze, save->has_target ? save->target : NULL, save->text);
        break;
    }
}

static void *run(void *argument)
{
    struct dmn_saver *saver = argument;

    pthread_mutex_lock(&saver->lock);
    while (!saver->stop) {
        struct dmn_save *save;

        if (saver->done == saver->count) {
            pthread_cond_wait(&saver->changed, &saver->lock);
            continue;
        }
        /* Its place in the ring is this thread's until it is marked done. */
        save = &saver->save[(saver->first + saver->done) % DMN_SAVES];
        pthread_mutex_unlock(&saver->lock);
        act(saver, save);
        pthread_mutex_lock(&saver->lock);
        saver->done++;
        saver->wake(saver->context);
    }
    pthread_mutex_unlock(&saver->lock);
    return NULL;
}

struct dmn_saver *dmn_saver_start(struct rnd_render *render, struct dmn_gaze *gaze,
                                  void (*wake)(void *context), void *context)
{
    struct dmn_saver *saver = calloc(1, sizeof(*saver));

    if (!saver) return NULL;
    saver->render = render;
    saver->gaze = gaze;
    saver->wake = wake;
    saver->context = context;
    pthread_mutex_init(&saver->lock, NULL);
    pthread_cond_init(&saver->changed, NULL);
    saver->started = !pthread_create(&saver->thread, NULL, run, saver);
    if (!saver->started) {
        dmn_saver_destroy(saver);
        return NULL;
    }
    return saver;
}

void dmn_saver_destroy(struct dmn_saver *saver)
{
    if (!saver) return;
    if (saver->started) {
        pthread_mutex_lock(&saver->lock);
        saver->stop = true;
        pthread_cond_signal(&saver->changed);
        pthread_mutex_unlock(&saver->lock);
        pthread_join(saver->thread, NULL);
    }
    pthread_cond_destroy(&saver->changed);
    pthread_mutex_destroy(&saver->lock);
    free(saver);
}

bool dmn_saver_ask(struct dmn_saver *saver, const struct dmn_save *save)
{
    bool room;

    pthread_mutex_lock(&saver->lock);
    room = saver->count < DMN_SAVES;
    if (room) {
        saver->save[(saver->first + saver->count++) % DMN_SAVES] = *save;
        pthread_cond_signal(&saver->changed);
    }
    pthread_mutex_unlock(&saver->lock);
    return room;
}

bool dmn_saver_take(struct dmn_saver *saver, struct dmn_save *out_save)
{
    bool found;

    pthread_mutex_lock(&saver->lock);
    found = saver->done > 0;
    if (found) {
        *out_save = saver->save[saver->first];
        saver->first = (saver->first + 1) % DMN_SAVES;
        saver->done--;
        saver->count--;
    }
    pthread_mutex_unlock(&saver->lock);
    return found;
}
