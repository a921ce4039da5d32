// What a fetcher knows of URLs: a hash table of entries, those that are settled also in a list from
// most to least recently used, within a bound of bytes; and its servers. Under the fetcher's lock.
// Inside the planet room.
#ifndef PERIGEE_PLANET_FETCH_TABLE_H
#define PERIGEE_PLANET_FETCH_TABLE_H

#include "planet/fetch.h"

struct http_transfer;

enum entry_state {
    ENTRY_LOOKING, // on disk, by the thread that asked first
    ENTRY_IN_LINE, // to be fetched, not before at_s
    ENTRY_ACTIVE,  // in flight
    ENTRY_BODY,    // settled, as are all that follow
    ENTRY_ABSENT,
    ENTRY_FAILED, // until at_s
    ENTRY_REFUSED,
};

enum { HOST_NAME_SIZE = 128, MAX_HOSTS = 64 };

struct fetch_host {
    char name[HOST_NAME_SIZE]; // scheme://host:port
    int failures;              // in a row
    int active;
    bool multiplexed;     // as its last answer
    double pause_until_s; // Retry-After, or down
    bool told_down, told_refused, told_rejected;
};

struct fetch_entry {
    char *url;
    struct fetch_host *host;
    enum entry_state state;
    uint64_t order;
    double at_s;
    int tries;
    size_t max_bytes;
    struct want **wants;
    int want_count, want_room;
    disk_item item; // the body, or while it is fetched again the old one
    fetch_body body;
    int holders;
    bool gone; // out of the table, freed by the last holder
    struct http_transfer *transfer;
    struct fetch_entry *chain;
    struct fetch_entry *newer, *older;             // settled and not held
    struct fetch_entry *line_next, *line_previous; // not settled
};

struct fetch_table {
    struct fetch_entry **buckets;
    size_t bucket_count, count;
    struct fetch_entry idle; // ring
    struct fetch_entry line; // ring of what is not settled
    size_t bytes, max_bytes; // of settled entries
    struct fetch_host hosts[MAX_HOSTS];
    int host_count;
};

void fetch_table_init(struct fetch_table *table, size_t max_bytes);
void fetch_table_deinit(struct fetch_table *table);

struct fetch_entry *fetch_table_find(struct fetch_table *table, const char *url);
// A new entry, ENTRY_LOOKING, in line.
struct fetch_entry *fetch_table_add(struct fetch_table *table, const char *url);
void fetch_table_remove(struct fetch_table *table, struct fetch_entry *entry);

// From the line to the settled; least recently used ones go when there are too many bytes.
void fetch_table_settle(struct fetch_table *table, struct fetch_entry *entry,
                        enum entry_state state);
// Back into the line: ENTRY_IN_LINE. It must not be held.
void fetch_table_reopen(struct fetch_table *table, struct fetch_entry *entry);

void fetch_table_hold(struct fetch_table *table, struct fetch_entry *entry);
void fetch_table_drop(struct fetch_table *table, struct fetch_entry *entry);
// The last used.
void fetch_table_touch(struct fetch_table *table, struct fetch_entry *entry);

// Adds a share of the want, once.
void fetch_entry_add_want(struct fetch_entry *entry, struct want *want);
// Gives all shares back.
void fetch_entry_wake(struct fetch_entry *entry);
// Gives the shares of those who have gone back. The least priority of the rest, INFINITY: nobody.
double fetch_entry_priority(struct fetch_entry *entry, bool keep_gone);

#endif
