// Tiles of servers as a source: the spec says where and how, the fetcher brings bodies, and reading
// a tile decodes and resamples them on the caller's thread. Opening contacts nobody. Any thread.
#ifndef PERIGEE_PLANET_SOURCE_REMOTE_H
#define PERIGEE_PLANET_SOURCE_REMOTE_H

#include "planet/fetch.h"
#include "planet/source.h"
#include "planet/source_spec.h"

// Takes the spec over, also when it fails. `fetcher` is borrowed and outlives the source.
status source_remote_open_take(source_spec *spec, struct fetcher *fetcher, struct source **out);

#endif
