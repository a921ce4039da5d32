// One GET by libcurl: http and https only, redirects to nothing else and never from https back,
// certificates verified, bytes bounded, and the answer as one of a few. Inside the planet room. A
// transfer belongs to one thread.
#ifndef PERIGEE_PLANET_HTTP_H
#define PERIGEE_PLANET_HTTP_H

#include <stddef.h>

#include <stdbool.h>

enum { HTTP_TAG_SIZE = 192, HTTP_WHY_SIZE = 160 };

enum http_result {
    HTTP_BODY,    // data, size
    HTTP_SAME,    // 304: what etag and modified name is still right
    HTTP_ABSENT,  // 404, 410, 204
    HTTP_LATER,   // 429, 5xx, no connection, cut short: may be tried again
    HTTP_REFUSED, // too large, forbidden, a redirect to where we do not go: not to be tried again
};

typedef struct http_answer {
    enum http_result result;
    unsigned char *data; // on the heap
    size_t size;
    char etag[HTTP_TAG_SIZE], modified[HTTP_TAG_SIZE]; // "": not said
    double max_age_s;                                  // < 0: not said
    double retry_after_s;                              // HTTP_LATER; < 0: not said
    bool multiplexed;                                  // by a protocol that shares connections
    char why[HTTP_WHY_SIZE];                           // HTTP_LATER, HTTP_REFUSED: one phrase
} http_answer;

typedef struct http_ask {
    const char *url;
    const char *etag, *modified; // of what is at hand; "" or NULL: nothing
    size_t max_bytes;
    double timeout_s;
} http_ask;

struct http_transfer;

// Is it a URL of http or https?
bool http_is_url(const char *text);

// Process-wide start of libcurl; any number of times, any thread.
void http_start(void);

// `owner` is what http_owner gives back. NULL when memory is out.
struct http_transfer *http_create(const http_ask *ask, void *owner);
void http_destroy(struct http_transfer **transfer);

void *http_easy(struct http_transfer *transfer); // CURL *
struct http_transfer *http_of_easy(void *easy);
void *http_owner(struct http_transfer *transfer);

// After the transfer has ended with CURLcode `code`. Takes the data out.
void http_finish(struct http_transfer *transfer, int code, http_answer *out);

#endif
