#include "app/size_search.h"

#include <math.h>

#include "base/vec.h"

#define STEP_MAX 1.4  // of the logarithm of size: a factor of four
#define NARROW   0.02 // likewise: two per cent

// Logarithms: of size, and of value over goal (turned so that it grows with the size).
struct point {
    double at, off;
    bool known;
};

struct search {
    const size_search_params *params;
    struct point below, above; // nearest known sizes that are too small and too large
    struct point best;
};

static double gap(struct point p)
{
    return p.known ? fabs(p.off) : INFINITY;
}

static void learn(struct search *s, struct point p)
{
    // A size to try lies between the two, or beyond the one that is known: it is always nearer.
    *(p.off < 0 ? &s->below : &s->above) = p;
    if (gap(p) < gap(s->best)) s->best = p;
}

// Nothing lies between the two known sizes but a step of the measure.
static bool is_narrow(const struct search *s)
{
    return s->below.known && s->above.known && s->above.at - s->below.at < NARROW;
}

static double next(const struct search *s)
{
    const size_search_params *p = s->params;
    double low = log(p->low), high = log(p->high);
    if (s->below.known && s->above.known) {
        double width = s->above.at - s->below.at;
        double at = s->below.at - s->below.off * width / (s->above.off - s->below.off);
        return clamp_double(at, s->below.at + 0.1 * width, s->above.at - 0.1 * width);
    }
    struct point from = s->below.known ? s->below : s->above;
    double step = clamp_double(-from.off / fabs(p->exponent), -STEP_MAX, STEP_MAX);
    return clamp_double(from.at + step, low, high);
}

status size_search(const size_search_params *params, size_search_result *out)
{
    struct search s = {.params = params};
    double at = 0, last = NAN, sign = params->exponent < 0 ? -1 : 1;
    *out = (size_search_result){.size = 1, .value = NAN};
    while (out->tries < params->tries && !out->met && fabs(at - last) != 0 && !is_narrow(&s)) {
        double value;
        status failed = params->measure(params->user, exp(at), &value);
        if (failed) return failed;
        out->tries++;
        last = at;
        if (!(value > 0)) break;
        learn(&s, (struct point){at, sign * log(value / params->goal), true});
        if (s.best.at == at) *out = (size_search_result){exp(at), value, false, out->tries};
        out->met = fabs(out->value - params->goal) <= params->tolerance * params->goal;
        at = next(&s);
    }
    return OK;
}
