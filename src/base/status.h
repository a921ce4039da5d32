// The one error convention: fallible functions return a status, OK = 0, results through the last
// pointer. The function that finds a fault logs it once, naming path, tile and value; callers pass
// the code up.
#ifndef PERIGEE_BASE_STATUS_H
#define PERIGEE_BASE_STATUS_H

typedef enum status {
    OK = 0,
    ERR_ARGUMENT,    // a value given by the user is impossible
    ERR_IO,          // the system refused to read or write
    ERR_FORMAT,      // file content is not what it should be
    ERR_VERSION,     // file content is of another schema version
    ERR_MEMORY,      // an allocation sized by data was refused
    ERR_GPU,         // no usable OpenGL, or a GL object could not be made
    ERR_NOT_FOUND,   // the thing asked for is not there
    ERR_CANCELLED,   // stopped on request
    ERR_TIMEOUT,     // not complete within the limit
    ERR_UNSUPPORTED, // understood, but not offered here
    ERR_PENDING,     // on its way: ask again
} status;

// A short English phrase for the code. Any thread.
const char *status_text(status s);

#endif
