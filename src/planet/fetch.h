// Bodies by URL, without waiting: asked for by many threads, fetched by one, many at a time and
// multiplexed where the server speaks HTTP/2. What is most wanted goes first; what nobody wants any
// more is stopped. Failures are tried again with growing pauses, Retry-After is kept to, and a
// server that does not answer is left alone for a while. Bodies stay in memory within a bound, and
// in the disk cache if there is one. Any thread.
#ifndef PERIGEE_PLANET_FETCH_H
#define PERIGEE_PLANET_FETCH_H

#include "planet/disk_cache.h"
#include "planet/want.h"

struct fetcher;

typedef struct fetch_params {
    int in_flight;           // at most; 0: 32
    int per_host;            // connections to one server at most, and without HTTP/2 transfers;
                             // 0: 6
    size_t memory_bytes;     // bodies and what is known of URLs; 0: 64 MiB
    double timeout_s;        // of one transfer; 0: 30
    bool first_come;         // ignore priorities and cancellation (to measure what they are worth)
    struct disk_cache *disk; // borrowed; NULL: none
} fetch_params;

typedef struct fetch_body {
    const unsigned char *data;
    size_t size;
} fetch_body;

struct fetch_counters {
    uint64_t started, finished, cancelled, retried, bytes; // transfers, and their bytes
    uint64_t from_disk, same, absent, refused, failed;     // answers
    size_t memory_bytes;                                   // now
    int in_flight, in_line;                                // now
    int stale; // of those in flight, now: nobody wants them any more
    int most_in_flight;
};

// Aborts when it gets no thread.
struct fetcher *fetcher_create(const fetch_params *params);
// Stops what is under way. No body may be held.
void fetcher_destroy(struct fetcher **fetcher);

// OK: the body, until released. ERR_PENDING: on its way, the want has a share in it.
// ERR_NOT_FOUND: the server has no such thing. ERR_IO: given up until *until_s (clock_now_s).
// ERR_FORMAT: refused for good (logged).
// A body larger than max_bytes is refused.
status fetch_get(struct fetcher *fetcher, const char *url, size_t max_bytes, struct want *want,
                 const fetch_body **out, double *until_s);
void fetch_release(struct fetcher *fetcher, const fetch_body **body);

// The same, but waits for at most `timeout_s`; then ERR_TIMEOUT. Not logged.
status fetch_wait(struct fetcher *fetcher, const char *url, size_t max_bytes, double timeout_s,
                  const fetch_body **out);

// What came under that URL was no tile: refused from now on, and not kept on disk. True the first
// time.
bool fetch_reject(struct fetcher *fetcher, const char *url);

void fetch_counters(struct fetcher *fetcher, struct fetch_counters *out);

#endif
