// One thread runs all transfers. The lock covers the table only: libcurl, the disk and the
// callers' decoding run without it. Entries in flight are taken out of the table by that thread
// alone.
#include "planet/fetch.h"

#include <curl/curl.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/memory.h"
#include "planet/fetch_table.h"
#include "planet/http.h"

enum { MAX_TRIES = 4, DOWN_AFTER = 8, LOOK_MS = 15, REST_MS = 1000 };

static const double FIRST_PAUSE_S = 0.25, LONGEST_PAUSE_S = 60, FAILED_S = 15;
static const double DEFAULT_AGE_S = 7 * 86400.0, ABSENT_AGE_S = 86400,
                    LONGEST_AGE_S = 365 * 86400.0;

struct fetcher {
    fetch_params params;
    CURLM *multi;
    pthread_t thread;
    pthread_mutex_t lock;
    struct fetch_table table;
    struct fetch_counters counters;
    uint64_t next_order;
    bool stopping;
};

// A pause before try n: doubled each time, and up to half as long again, by the place in line, so
// that not all come back at once.
static double pause_of(const struct fetch_entry *e)
{
    double spread = 1 + 0.5 * (double)(e->order * 2654435761u % 1024) / 1024;
    return fmin(FIRST_PAUSE_S * ldexp(1, e->tries - 1) * spread, LONGEST_PAUSE_S);
}

// What is left when a server does not answer: the old body, if there is one.
static void give_up(struct fetcher *f, struct fetch_entry *e, double until_s)
{
    if (e->item.data) {
        fetch_table_settle(&f->table, e, ENTRY_BODY);
        return;
    }
    f->counters.failed++;
    e->at_s = until_s;
    fetch_table_settle(&f->table, e, ENTRY_FAILED);
}

static void keep_on_disk(struct fetcher *f, const struct fetch_entry *e, const http_answer *a,
                         double usual_age_s)
{
    if (!f->params.disk) return;
    disk_item item = {.data = a->data, .size = a->size};
    item.max_age_s = fmin(a->max_age_s >= 0 ? a->max_age_s : usual_age_s, LONGEST_AGE_S);
    memcpy(item.etag, a->etag, sizeof item.etag);
    memcpy(item.modified, a->modified, sizeof item.modified);
    if (a->result == HTTP_SAME) disk_cache_renew(f->params.disk, e->url, item.max_age_s);
    else disk_cache_put(f->params.disk, e->url, &item);
}

static void refuse(struct fetcher *f, struct fetch_entry *e, const char *why)
{
    f->counters.refused++;
    if (!e->host->told_refused) log_warn("%s: refused: %s", e->url, why);
    else log_debug("%s: refused: %s", e->url, why);
    e->host->told_refused = true;
    fetch_table_settle(&f->table, e, ENTRY_REFUSED);
}

static void server_failed(struct fetch_host *h, const http_answer *a)
{
    double now = clock_now_s();
    // Those that were in flight when it went down count as one.
    if (h->failures >= DOWN_AFTER && now < h->pause_until_s) return;
    h->failures++;
    if (a->retry_after_s > 0)
        h->pause_until_s = fmax(h->pause_until_s, now + fmin(a->retry_after_s, LONGEST_PAUSE_S));
    if (h->failures < DOWN_AFTER) return;
    double pause = fmin(ldexp(1, h->failures - DOWN_AFTER < 6 ? h->failures - DOWN_AFTER : 6),
                        LONGEST_PAUSE_S);
    h->pause_until_s = fmax(h->pause_until_s, now + pause);
    if (!h->told_down) log_warn("%s: %s; going on without it", h->name, a->why);
    h->told_down = true;
}

static void try_later(struct fetcher *f, struct fetch_entry *e, const http_answer *a)
{
    server_failed(e->host, a);
    double now = clock_now_s();
    e->tries++;
    if (e->tries >= MAX_TRIES) {
        log_debug("%s: %s", e->url, a->why);
        give_up(f, e, now + FAILED_S);
        return;
    }
    f->counters.retried++;
    e->state = ENTRY_IN_LINE;
    e->at_s = now + pause_of(e);
}

static void server_answered(struct fetch_host *h)
{
    if (h->told_down) log_info("%s: answers again", h->name);
    h->failures = 0;
    h->told_down = false;
}

// Under the lock.
static void take_answer(struct fetcher *f, struct fetch_entry *e, http_answer *a)
{
    f->counters.finished++;
    f->counters.bytes += a->size;
    if (a->result != HTTP_LATER) server_answered(e->host);
    e->host->multiplexed = a->multiplexed;
    switch (a->result) {
    case HTTP_BODY:
        disk_item_deinit(&e->item);
        e->item.data = a->data;
        e->item.size = a->size;
        fetch_table_settle(&f->table, e, ENTRY_BODY);
        break;
    case HTTP_SAME:
        f->counters.same++;
        if (e->item.data) fetch_table_settle(&f->table, e, ENTRY_BODY);
        else refuse(f, e, "answer 304 to a first question");
        break;
    case HTTP_ABSENT:
        f->counters.absent++;
        fetch_table_settle(&f->table, e, ENTRY_ABSENT);
        break;
    case HTTP_LATER:
        try_later(f, e, a);
        break;
    case HTTP_REFUSED:
        refuse(f, e, a->why);
        break;
    }
}

static void leave_flight(struct fetcher *f, struct fetch_entry *e)
{
    e->host->active--;
    f->counters.in_flight--;
    curl_multi_remove_handle(f->multi, http_easy(e->transfer));
    http_destroy(&e->transfer);
}

static void finish(struct fetcher *f, CURL *easy, CURLcode code)
{
    struct http_transfer *t = http_of_easy(easy);
    struct fetch_entry *e = http_owner(t);
    http_answer answer;
    http_finish(t, (int)code, &answer);
    if (answer.result == HTTP_BODY || answer.result == HTTP_SAME)
        keep_on_disk(f, e, &answer, DEFAULT_AGE_S);
    if (answer.result == HTTP_ABSENT) keep_on_disk(f, e, &answer, ABSENT_AGE_S);
    pthread_mutex_lock(&f->lock);
    leave_flight(f, e);
    take_answer(f, e, &answer);
    pthread_mutex_unlock(&f->lock);
}

// Takes out what nobody wants, and counts what is left.
static void sweep(struct fetcher *f)
{
    int in_line = 0;
    for (struct fetch_entry *e = f->table.line.line_next, *next; e != &f->table.line; e = next) {
        next = e->line_next;
        if (e->state == ENTRY_LOOKING) continue;
        if (isinf(fetch_entry_priority(e, f->params.first_come))) {
            if (e->state == ENTRY_ACTIVE) {
                leave_flight(f, e);
                f->counters.cancelled++;
            }
            fetch_table_remove(&f->table, e);
        } else if (e->state == ENTRY_IN_LINE) {
            in_line++;
            if (e->host->failures >= DOWN_AFTER && e->host->pause_until_s > clock_now_s())
                give_up(f, e, e->host->pause_until_s);
        }
    }
    f->counters.in_line = in_line;
}

// May a transfer to this server start? One that was down is tried by one. Where transfers do not
// share connections there are no more of them than connections: the rest would wait inside libcurl
// in the order of asking.
static bool host_ready(const struct fetcher *f, const struct fetch_host *h, double now)
{
    if (!h->multiplexed && h->active >= f->params.per_host) return false;
    return now >= h->pause_until_s && (h->failures < DOWN_AFTER || h->active == 0);
}

static struct fetch_entry *most_wanted(struct fetcher *f, double now)
{
    struct fetch_entry *best = NULL;
    double best_priority = INFINITY;
    for (struct fetch_entry *e = f->table.line.line_next; e != &f->table.line; e = e->line_next) {
        if (e->state != ENTRY_IN_LINE || now < e->at_s || !host_ready(f, e->host, now)) continue;
        double priority = f->params.first_come ? 0 : fetch_entry_priority(e, false);
        if (best &&
            (priority > best_priority || (priority == best_priority && e->order > best->order)))
            continue;
        best = e;
        best_priority = priority;
    }
    return best;
}

static void start_one(struct fetcher *f, struct fetch_entry *e)
{
    http_ask ask = {e->url, e->item.etag, e->item.modified, e->max_bytes, f->params.timeout_s};
    if (!e->item.data) ask.etag = ask.modified = NULL;
    e->transfer = http_create(&ask, e);
    if (!e->transfer || curl_multi_add_handle(f->multi, http_easy(e->transfer)) != CURLM_OK) {
        http_destroy(&e->transfer);
        give_up(f, e, clock_now_s() + FAILED_S);
        return;
    }
    e->state = ENTRY_ACTIVE;
    e->host->active++;
    f->counters.started++;
    if (++f->counters.in_flight > f->counters.most_in_flight)
        f->counters.most_in_flight = f->counters.in_flight;
}

static void start_some(struct fetcher *f)
{
    double now = clock_now_s();
    while (f->counters.in_flight < f->params.in_flight) {
        struct fetch_entry *e = most_wanted(f, now);
        if (!e) break;
        start_one(f, e);
    }
}

static void *run(void *arg)
{
    struct fetcher *f = arg;
    for (bool stop = false; !stop;) {
        int running, left, busy;
        pthread_mutex_lock(&f->lock);
        sweep(f);
        start_some(f);
        busy = f->counters.in_flight || f->counters.in_line;
        stop = f->stopping;
        pthread_mutex_unlock(&f->lock);
        curl_multi_perform(f->multi, &running);
        for (CURLMsg *m; (m = curl_multi_info_read(f->multi, &left));)
            if (m->msg == CURLMSG_DONE) finish(f, m->easy_handle, m->data.result);
        if (!stop) curl_multi_poll(f->multi, NULL, 0, busy ? LOOK_MS : REST_MS, NULL);
    }
    return NULL;
}

struct fetcher *fetcher_create(const fetch_params *params)
{
    struct fetcher *f = NEW(struct fetcher);
    f->params = *params;
    if (f->params.in_flight <= 0) f->params.in_flight = 32;
    if (f->params.per_host <= 0) f->params.per_host = 6;
    if (!(f->params.timeout_s > 0)) f->params.timeout_s = 30;
    if (!f->params.memory_bytes) f->params.memory_bytes = (size_t)64 << 20;
    fetch_table_init(&f->table, f->params.memory_bytes);
    pthread_mutex_init(&f->lock, NULL);
    http_start();
    f->multi = curl_multi_init();
    curl_multi_setopt(f->multi, CURLMOPT_PIPELINING, (long)CURLPIPE_MULTIPLEX);
    curl_multi_setopt(f->multi, CURLMOPT_MAX_HOST_CONNECTIONS, (long)f->params.per_host);
    if (!f->multi || pthread_create(&f->thread, NULL, run, f)) {
        log_error("no thread for the network");
        abort();
    }
    return f;
}

void fetcher_destroy(struct fetcher **fetcher)
{
    struct fetcher *f = *fetcher;
    if (!f) return;
    pthread_mutex_lock(&f->lock);
    f->stopping = true;
    pthread_mutex_unlock(&f->lock);
    curl_multi_wakeup(f->multi);
    pthread_join(f->thread, NULL);
    struct fetch_entry *line = &f->table.line;
    for (struct fetch_entry *e = line->line_next; e != line; e = e->line_next)
        if (e->transfer) leave_flight(f, e);
    curl_multi_cleanup(f->multi);
    fetch_table_deinit(&f->table);
    pthread_mutex_destroy(&f->lock);
    free(f);
    *fetcher = NULL;
}

// A URL asked for the first time: what the disk has of it, without the lock.
static void look_on_disk(struct fetcher *f, struct fetch_entry *e)
{
    disk_item item = {0};
    bool found = false;
    if (f->params.disk) {
        pthread_mutex_unlock(&f->lock);
        found = disk_cache_get(f->params.disk, e->url, &item);
        pthread_mutex_lock(&f->lock);
    }
    e->item = item;
    e->state = ENTRY_IN_LINE;
    if (!found || !(item.max_age_s > 0)) return;
    f->counters.from_disk++;
    fetch_table_settle(&f->table, e, item.data ? ENTRY_BODY : ENTRY_ABSENT);
}

static status answer_of(struct fetcher *f, struct fetch_entry *e, const fetch_body **out,
                        double *until_s)
{
    fetch_table_touch(&f->table, e);
    switch (e->state) {
    case ENTRY_BODY:
        fetch_table_hold(&f->table, e);
        *out = &e->body;
        return OK;
    case ENTRY_ABSENT:
        return ERR_NOT_FOUND;
    case ENTRY_FAILED:
        *until_s = e->at_s;
        return ERR_IO;
    case ENTRY_REFUSED:
        return ERR_FORMAT;
    default:
        return ERR_PENDING;
    }
}

status fetch_get(struct fetcher *f, const char *url, size_t max_bytes, struct want *want,
                 const fetch_body **out, double *until_s)
{
    *out = NULL;
    *until_s = INFINITY;
    pthread_mutex_lock(&f->lock);
    struct fetch_entry *e = fetch_table_find(&f->table, url);
    if (!e) {
        e = fetch_table_add(&f->table, url);
        e->order = f->next_order++;
        e->max_bytes = max_bytes;
        look_on_disk(f, e);
    } else if (e->state == ENTRY_FAILED && clock_now_s() >= e->at_s) {
        fetch_table_reopen(&f->table, e);
    }
    status s = answer_of(f, e, out, until_s);
    if (s == ERR_PENDING) {
        fetch_entry_add_want(e, want);
        curl_multi_wakeup(f->multi);
    }
    pthread_mutex_unlock(&f->lock);
    return s;
}

static struct fetch_entry *entry_of(const fetch_body *body)
{
    return (struct fetch_entry *)((char *)body - offsetof(struct fetch_entry, body));
}

void fetch_release(struct fetcher *f, const fetch_body **body)
{
    if (!*body) return;
    pthread_mutex_lock(&f->lock);
    fetch_table_drop(&f->table, entry_of(*body));
    pthread_mutex_unlock(&f->lock);
    *body = NULL;
}

status fetch_wait(struct fetcher *f, const char *url, size_t max_bytes, double timeout_s,
                  const fetch_body **out)
{
    double end = clock_now_s() + timeout_s, until_s;
    struct want *want = want_create(-1);
    status s;
    while ((s = fetch_get(f, url, max_bytes, want, out, &until_s)) == ERR_PENDING) {
        double left = end - clock_now_s();
        if (left <= 0) {
            s = ERR_TIMEOUT;
            break;
        }
        want_wait(want, left);
    }
    want_release(&want);
    return s;
}

bool fetch_reject(struct fetcher *f, const char *url)
{
    if (f->params.disk) disk_cache_forget(f->params.disk, url);
    pthread_mutex_lock(&f->lock);
    struct fetch_entry *e = fetch_table_find(&f->table, url);
    bool first = e && e->state == ENTRY_BODY;
    if (first) {
        struct fetch_host *host = e->host;
        fetch_table_remove(&f->table, e);
        e = fetch_table_add(&f->table, url);
        fetch_table_settle(&f->table, e, ENTRY_REFUSED);
        f->counters.refused++;
        first = !host->told_rejected;
        host->told_rejected = true;
    }
    pthread_mutex_unlock(&f->lock);
    return first;
}

void fetch_counters(struct fetcher *f, struct fetch_counters *out)
{
    pthread_mutex_lock(&f->lock);
    *out = f->counters;
    out->memory_bytes = f->table.bytes;
    for (struct fetch_entry *e = f->table.line.line_next; e != &f->table.line; e = e->line_next) {
        bool wanted = false;
        for (int i = 0; i < e->want_count; i++) wanted |= !want_cancelled(e->wants[i]);
        out->stale += e->state == ENTRY_ACTIVE && !wanted;
    }
    pthread_mutex_unlock(&f->lock);
}
