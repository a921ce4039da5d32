// Invariant: an entry in the table is in exactly one of: the line, the idle ring, held.
#include "planet/fetch_table.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "planet/store.h"

enum { BUCKETS = 1 << 14, ENTRY_COST = 400 };

void fetch_table_init(struct fetch_table *t, size_t max_bytes)
{
    *t = (struct fetch_table){.max_bytes = max_bytes, .bucket_count = BUCKETS};
    t->buckets = NEW_ARRAY(struct fetch_entry *, BUCKETS);
    t->idle.newer = t->idle.older = &t->idle;
    t->line.line_next = t->line.line_previous = &t->line;
}

static void entry_free(struct fetch_entry *e)
{
    fetch_entry_wake(e);
    disk_item_deinit(&e->item);
    free(e->wants);
    free(e->url);
    free(e);
}

void fetch_table_deinit(struct fetch_table *t)
{
    for (size_t i = 0; i < t->bucket_count; i++)
        while (t->buckets[i]) {
            struct fetch_entry *e = t->buckets[i];
            t->buckets[i] = e->chain;
            entry_free(e);
        }
    free(t->buckets);
}

static struct fetch_entry **bucket_of(struct fetch_table *t, const char *url)
{
    return &t->buckets[(uint64_t)store_hash(url, strlen(url)) % t->bucket_count];
}

struct fetch_entry *fetch_table_find(struct fetch_table *t, const char *url)
{
    struct fetch_entry *e = *bucket_of(t, url);
    while (e && strcmp(e->url, url) != 0) e = e->chain;
    return e;
}

// Servers beyond MAX_HOSTS share the last place.
static struct fetch_host *host_of(struct fetch_table *t, const char *url)
{
    char name[HOST_NAME_SIZE];
    const char *slashes = strstr(url, "://");
    size_t length = slashes ? (size_t)(slashes + 3 - url) : 0;
    length += strcspn(url + length, "/?#");
    snprintf(name, sizeof name, "%.*s", (int)(length < 120 ? length : 120), url);
    for (int i = 0; i < t->host_count; i++)
        if (strcmp(t->hosts[i].name, name) == 0) return &t->hosts[i];
    if (t->host_count == MAX_HOSTS) return &t->hosts[MAX_HOSTS - 1];
    struct fetch_host *host = &t->hosts[t->host_count++];
    strcpy(host->name, name);
    return host;
}

static void line_add(struct fetch_table *t, struct fetch_entry *e)
{
    e->line_next = &t->line;
    e->line_previous = t->line.line_previous;
    e->line_previous->line_next = e;
    t->line.line_previous = e;
}

static void line_remove(struct fetch_entry *e)
{
    e->line_next->line_previous = e->line_previous;
    e->line_previous->line_next = e->line_next;
    e->line_next = e->line_previous = NULL;
}

static void idle_add(struct fetch_table *t, struct fetch_entry *e)
{
    e->newer = &t->idle;
    e->older = t->idle.older;
    e->older->newer = e;
    t->idle.older = e;
}

static void idle_remove(struct fetch_entry *e)
{
    e->newer->older = e->older;
    e->older->newer = e->newer;
    e->newer = e->older = NULL;
}

struct fetch_entry *fetch_table_add(struct fetch_table *t, const char *url)
{
    struct fetch_entry *e = NEW(struct fetch_entry), **bucket = bucket_of(t, url);
    e->url = NEW_ARRAY(char, strlen(url) + 1);
    strcpy(e->url, url);
    e->host = host_of(t, url);
    e->chain = *bucket;
    *bucket = e;
    t->count++;
    line_add(t, e);
    return e;
}

static size_t cost_of(const struct fetch_entry *e)
{
    return ENTRY_COST + strlen(e->url) + e->item.size;
}

void fetch_table_remove(struct fetch_table *t, struct fetch_entry *e)
{
    struct fetch_entry **link = bucket_of(t, e->url);
    while (*link != e) link = &(*link)->chain;
    *link = e->chain;
    t->count--;
    if (e->line_next) line_remove(e);
    else t->bytes -= cost_of(e);
    if (e->newer) idle_remove(e);
    e->gone = true;
    if (!e->holders) entry_free(e);
}

void fetch_table_settle(struct fetch_table *t, struct fetch_entry *e, enum entry_state state)
{
    line_remove(e);
    e->state = state;
    e->tries = 0;
    if (state != ENTRY_BODY) disk_item_deinit(&e->item);
    e->body = (fetch_body){e->item.data, e->item.size};
    t->bytes += cost_of(e);
    idle_add(t, e);
    fetch_entry_wake(e);
    // The newest stays whatever its size, so that who asked for it finds it.
    while (t->bytes > t->max_bytes && t->idle.newer != e && t->idle.newer != &t->idle)
        fetch_table_remove(t, t->idle.newer);
}

void fetch_table_reopen(struct fetch_table *t, struct fetch_entry *e)
{
    assert(!e->holders && !e->line_next);
    t->bytes -= cost_of(e);
    idle_remove(e);
    e->state = ENTRY_IN_LINE;
    line_add(t, e);
}

void fetch_table_hold(struct fetch_table *t, struct fetch_entry *e)
{
    (void)t;
    if (e->holders++ == 0) idle_remove(e);
}

void fetch_table_drop(struct fetch_table *t, struct fetch_entry *e)
{
    assert(e->holders > 0);
    if (--e->holders) return;
    if (e->gone) entry_free(e);
    else idle_add(t, e);
}

void fetch_table_touch(struct fetch_table *t, struct fetch_entry *e)
{
    if (!e->newer) return;
    idle_remove(e);
    idle_add(t, e);
}

void fetch_entry_add_want(struct fetch_entry *e, struct want *want)
{
    for (int i = 0; i < e->want_count; i++)
        if (e->wants[i] == want) return;
    if (e->want_count == e->want_room) {
        int room = e->want_room ? 2 * e->want_room : 4;
        struct want **wants = NEW_ARRAY(struct want *, (size_t)room);
        if (e->want_count) memcpy(wants, e->wants, sizeof *wants * (size_t)e->want_count);
        free(e->wants);
        e->wants = wants;
        e->want_room = room;
    }
    e->wants[e->want_count++] = want_take(want);
}

void fetch_entry_wake(struct fetch_entry *e)
{
    for (int i = 0; i < e->want_count; i++) want_give_back(&e->wants[i]);
    e->want_count = 0;
}

double fetch_entry_priority(struct fetch_entry *e, bool keep_gone)
{
    double best = INFINITY;
    for (int i = 0; i < e->want_count;) {
        if (want_cancelled(e->wants[i]) && !keep_gone) {
            want_give_back(&e->wants[i]);
            e->wants[i] = e->wants[--e->want_count];
            continue;
        }
        best = fmin(best, want_priority(e->wants[i]));
        i++;
    }
    return best;
}
