// libcurl at the room's edge.
#include "planet/http.h"

#include <curl/curl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/memory.h"

enum { CONNECT_TIMEOUT_S = 10, MAX_REDIRECTS = 4, FIRST_ROOM = 32 << 10 };

struct http_transfer {
    CURL *easy;
    void *owner;
    struct curl_slist *headers;
    unsigned char *data;
    size_t size, room, max_bytes;
    bool too_large, no_memory;
    char error[CURL_ERROR_SIZE];
};

static pthread_once_t start_once = PTHREAD_ONCE_INIT;

static void start(void)
{
    curl_global_init(CURL_GLOBAL_DEFAULT);
}

void http_start(void)
{
    pthread_once(&start_once, start);
}

bool http_is_url(const char *text)
{
    return strncasecmp(text, "http://", 7) == 0 || strncasecmp(text, "https://", 8) == 0;
}

static size_t take(char *bytes, size_t one, size_t count, void *user)
{
    struct http_transfer *t = user;
    (void)one;
    if (count > t->max_bytes - t->size) {
        t->too_large = true;
        return 0;
    }
    if (t->size + count > t->room) {
        size_t room = t->room ? 2 * t->room : FIRST_ROOM;
        while (room < t->size + count) room *= 2;
        unsigned char *data = realloc(t->data, room);
        if (!data) {
            t->no_memory = true;
            return 0;
        }
        t->data = data;
        t->room = room;
    }
    memcpy(t->data + t->size, bytes, count);
    t->size += count;
    return count;
}

static void add_header(struct http_transfer *t, const char *name, const char *value)
{
    char line[HTTP_TAG_SIZE + 32];
    if (!value || !value[0]) return;
    snprintf(line, sizeof line, "%s: %s", name, value);
    struct curl_slist *more = curl_slist_append(t->headers, line);
    if (more) t->headers = more;
}

static void set_options(struct http_transfer *t, const http_ask *ask)
{
    CURL *e = t->easy;
    bool secure = strncasecmp(ask->url, "https", 5) == 0;
    curl_easy_setopt(e, CURLOPT_URL, ask->url);
    curl_easy_setopt(e, CURLOPT_PRIVATE, t);
    curl_easy_setopt(e, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(e, CURLOPT_REDIR_PROTOCOLS_STR, secure ? "https" : "http,https");
    curl_easy_setopt(e, CURLOPT_FOLLOWLOCATION, 1L);
    curl_easy_setopt(e, CURLOPT_MAXREDIRS, (long)MAX_REDIRECTS);
    curl_easy_setopt(e, CURLOPT_SSL_VERIFYPEER, 1L);
    curl_easy_setopt(e, CURLOPT_SSL_VERIFYHOST, 2L);
    const char *authorities = getenv("SSL_CERT_FILE"); // as OpenSSL has it
    if (authorities && authorities[0]) curl_easy_setopt(e, CURLOPT_CAINFO, authorities);
    curl_easy_setopt(e, CURLOPT_HTTP_VERSION, (long)CURL_HTTP_VERSION_2TLS);
    curl_easy_setopt(e, CURLOPT_PIPEWAIT, 1L);
    curl_easy_setopt(e, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(e, CURLOPT_USERAGENT, "Perigee/" PERIGEE_VERSION);
    curl_easy_setopt(e, CURLOPT_CONNECTTIMEOUT, (long)CONNECT_TIMEOUT_S);
    curl_easy_setopt(e, CURLOPT_TIMEOUT_MS, (long)(ask->timeout_s * 1e3));
    curl_easy_setopt(e, CURLOPT_MAXFILESIZE_LARGE, (curl_off_t)ask->max_bytes);
    curl_easy_setopt(e, CURLOPT_WRITEFUNCTION, take);
    curl_easy_setopt(e, CURLOPT_WRITEDATA, t);
    curl_easy_setopt(e, CURLOPT_ERRORBUFFER, t->error);
    curl_easy_setopt(e, CURLOPT_HTTPHEADER, t->headers);
}

struct http_transfer *http_create(const http_ask *ask, void *owner)
{
    struct http_transfer *t = NEW(struct http_transfer);
    t->owner = owner;
    t->max_bytes = ask->max_bytes;
    t->easy = curl_easy_init();
    if (!t->easy) {
        free(t);
        return NULL;
    }
    add_header(t, "If-None-Match", ask->etag);
    if (!ask->etag || !ask->etag[0]) add_header(t, "If-Modified-Since", ask->modified);
    set_options(t, ask);
    return t;
}

void http_destroy(struct http_transfer **transfer)
{
    struct http_transfer *t = *transfer;
    if (!t) return;
    curl_easy_cleanup(t->easy);
    curl_slist_free_all(t->headers);
    free(t->data);
    free(t);
    *transfer = NULL;
}

void *http_easy(struct http_transfer *t)
{
    return t->easy;
}

struct http_transfer *http_of_easy(void *easy)
{
    char *t = NULL;
    curl_easy_getinfo((CURL *)easy, CURLINFO_PRIVATE, &t);
    return (struct http_transfer *)(void *)t;
}

void *http_owner(struct http_transfer *t)
{
    return t->owner;
}

static const char *header_of(struct http_transfer *t, const char *name)
{
    struct curl_header *header;
    return curl_easy_header(t->easy, name, 0, CURLH_HEADER, -1, &header) == CURLHE_OK
               ? header->value
               : "";
}

static void copy_tag(struct http_transfer *t, const char *name, char out[HTTP_TAG_SIZE])
{
    const char *value = header_of(t, name);
    // A tag that was cut short would never match.
    snprintf(out, HTTP_TAG_SIZE, "%s", strlen(value) < HTTP_TAG_SIZE ? value : "");
}

static double max_age_of(struct http_transfer *t)
{
    const char *control = header_of(t, "Cache-Control"), *age = strstr(control, "max-age=");
    if (strstr(control, "no-store") || strstr(control, "no-cache")) return 0;
    if (!age) return -1;
    double seconds = strtod(age + 8, NULL);
    return seconds >= 0 ? seconds : -1;
}

// Transfers that broke: by what is worth a second try.
static void classify_failure(struct http_transfer *t, CURLcode code, http_answer *out)
{
    out->result = HTTP_LATER;
    if (t->too_large || code == CURLE_FILESIZE_EXCEEDED) {
        out->result = HTTP_REFUSED;
        snprintf(out->why, sizeof out->why, "larger than %zu bytes", t->max_bytes);
        return;
    }
    if (code == CURLE_UNSUPPORTED_PROTOCOL || code == CURLE_TOO_MANY_REDIRECTS ||
        code == CURLE_URL_MALFORMAT || code == CURLE_PEER_FAILED_VERIFICATION)
        out->result = HTTP_REFUSED;
    snprintf(out->why, sizeof out->why, "%.150s",
             t->error[0] ? t->error : curl_easy_strerror(code));
}

static void classify_status(long http, http_answer *out)
{
    if (http == 200) out->result = HTTP_BODY;
    else if (http == 304) out->result = HTTP_SAME;
    else if (http == 404 || http == 410 || http == 204) out->result = HTTP_ABSENT;
    else if (http == 408 || http == 425 || http == 429 || http >= 500) out->result = HTTP_LATER;
    else out->result = HTTP_REFUSED;
    snprintf(out->why, sizeof out->why, "answer %ld", http);
}

void http_finish(struct http_transfer *t, int code, http_answer *out)
{
    *out = (http_answer){.max_age_s = -1, .retry_after_s = -1};
    long http = 0;
    curl_off_t retry = 0;
    curl_easy_getinfo(t->easy, CURLINFO_RESPONSE_CODE, &http);
    if (code != CURLE_OK) {
        classify_failure(t, (CURLcode)code, out);
        return;
    }
    long version = 0;
    curl_easy_getinfo(t->easy, CURLINFO_HTTP_VERSION, &version);
    out->multiplexed = version >= CURL_HTTP_VERSION_2_0;
    classify_status(http, out);
    copy_tag(t, "ETag", out->etag);
    copy_tag(t, "Last-Modified", out->modified);
    out->max_age_s = max_age_of(t);
    if (curl_easy_getinfo(t->easy, CURLINFO_RETRY_AFTER, &retry) == CURLE_OK && retry > 0)
        out->retry_after_s = (double)retry;
    if (out->result != HTTP_BODY) return;
    out->data = t->data;
    out->size = t->size;
    t->data = NULL;
}
