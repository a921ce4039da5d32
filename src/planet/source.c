// The calls through the table of a source.
#include "planet/source.h"

#include <math.h>

bool source_has(const struct source *source, tile_id id)
{
    return source->ops->has(source, id);
}

status source_read(struct source *source, tile_id id, struct want *want, void *samples,
                   double *until_s)
{
    *until_s = INFINITY;
    return source->ops->read(source, id, want, samples, until_s);
}

void source_counters(struct source *source, struct source_counters *out)
{
    *out = (struct source_counters){0};
    if (source->ops->counters) source->ops->counters(source, out);
}

void source_close(struct source **source)
{
    if (*source) (*source)->ops->close(*source);
    *source = NULL;
}
