// A ring of frames, each with a pair of timestamps a pass. A slot is read when the driver says it
// has the result, and its measure is dropped when it has none by the time the slot comes round
// again.
#include "gpu/timer.h"

#include <assert.h>
#include <stdbool.h>
#include <stdlib.h>

#include <epoxy/gl.h>

#include "base/memory.h"

enum { FRAMES = 4 };

struct frame {
    GLuint begin[GPU_TIMER_PASSES], end[GPU_TIMER_PASSES];
    unsigned ended; // bit a pass: its pair is written and not yet read
};

struct gpu_timer {
    struct frame frames[FRAMES];
    double ms[GPU_TIMER_PASSES];
    int current;
    bool works; // the driver's timestamps count
};

struct gpu_timer *gpu_timer_create(void)
{
    struct gpu_timer *t = NEW(struct gpu_timer);
    GLint bits = 0;
    glGetQueryiv(GL_TIMESTAMP, GL_QUERY_COUNTER_BITS, &bits);
    t->works = bits > 0;
    for (int i = 0; i < GPU_TIMER_PASSES; i++) t->ms[i] = -1.0;
    for (int i = 0; i < FRAMES; i++) {
        glCreateQueries(GL_TIMESTAMP, GPU_TIMER_PASSES, t->frames[i].begin);
        glCreateQueries(GL_TIMESTAMP, GPU_TIMER_PASSES, t->frames[i].end);
    }
    return t;
}

void gpu_timer_destroy(struct gpu_timer **timer)
{
    struct gpu_timer *t = *timer;
    if (!t) return;
    for (int i = 0; i < FRAMES; i++) {
        glDeleteQueries(GPU_TIMER_PASSES, t->frames[i].begin);
        glDeleteQueries(GPU_TIMER_PASSES, t->frames[i].end);
    }
    free(t);
    *timer = NULL;
}

void gpu_timer_begin(struct gpu_timer *t, int pass)
{
    assert(pass >= 0 && pass < GPU_TIMER_PASSES);
    if (t->works) glQueryCounter(t->frames[t->current].begin[pass], GL_TIMESTAMP);
}

void gpu_timer_end(struct gpu_timer *t, int pass)
{
    assert(pass >= 0 && pass < GPU_TIMER_PASSES);
    if (!t->works) return;
    glQueryCounter(t->frames[t->current].end[pass], GL_TIMESTAMP);
    t->frames[t->current].ended |= 1u << pass;
}

static void read_pass(struct gpu_timer *t, struct frame *f, int pass)
{
    GLint available = GL_FALSE;
    glGetQueryObjectiv(f->end[pass], GL_QUERY_RESULT_AVAILABLE, &available);
    if (!available) return;
    GLuint64 begin = 0, end = 0;
    glGetQueryObjectui64v(f->begin[pass], GL_QUERY_RESULT, &begin);
    glGetQueryObjectui64v(f->end[pass], GL_QUERY_RESULT, &end);
    t->ms[pass] = (double)(end - begin) * 1e-6;
    f->ended &= ~(1u << pass);
}

// Oldest frame first, so that the newest known time stays; the frame just ended is left for the
// next call.
void gpu_timer_frame(struct gpu_timer *t)
{
    for (int age = FRAMES - 1; age > 0; age--) {
        struct frame *f = &t->frames[(t->current + FRAMES - age) % FRAMES];
        for (int pass = 0; pass < GPU_TIMER_PASSES; pass++)
            if (f->ended & 1u << pass) read_pass(t, f, pass);
    }
    t->current = (t->current + 1) % FRAMES;
    t->frames[t->current].ended = 0;
}

double gpu_timer_ms(const struct gpu_timer *t, int pass)
{
    assert(pass >= 0 && pass < GPU_TIMER_PASSES);
    return t->ms[pass];
}
