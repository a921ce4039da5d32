#include "fault_server.h"

#include <arpa/inet.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

static int server_port, control[2];
static pid_t child;

int fault_server_start(int port)
{
    int in[2], out[2];
    char text[16];
    snprintf(text, sizeof text, "%d", port);
    if (pipe(in) || pipe(out)) exit(1);
    child = fork();
    if (child == 0) {
        dup2(in[0], 0);
        dup2(out[1], 1);
        close(in[1]);
        close(out[0]);
        execlp("python3", "python3", FAULT_SERVER, text, (char *)NULL);
        _exit(127);
    }
    close(in[0]);
    close(out[1]);
    control[1] = in[1];
    FILE *said = fdopen(out[0], "r");
    if (fscanf(said, "%d", &server_port) != 1) {
        puts("no tile server: python3 is needed");
        exit(77);
    }
    fclose(said);
    return server_port;
}

void fault_server_stop(void)
{
    kill(child, SIGKILL);
    close(control[1]);
    waitpid(child, NULL, 0);
}

const char *fault_url(const char *path)
{
    static char rooms[8][256];
    static int next;
    char *room = rooms[next++ % 8];
    snprintf(room, sizeof rooms[0], "http://127.0.0.1:%d%s", server_port, path);
    return room;
}

// One request by hand, so that what is tested does not test itself.
static void ask(const char *path, char *out, size_t size)
{
    struct sockaddr_in to = {.sin_family = AF_INET, .sin_port = htons((unsigned short)server_port)};
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    int s = socket(AF_INET, SOCK_STREAM, 0);
    char text[256];
    size_t used = 0;
    int n = snprintf(text, sizeof text, "GET %s HTTP/1.0\r\n\r\n", path);
    if (connect(s, (struct sockaddr *)&to, sizeof to) || write(s, text, (size_t)n) != n) exit(1);
    for (ssize_t got; (got = read(s, out + used, size - 1 - used)) > 0;) used += (size_t)got;
    out[used] = '\0';
    close(s);
}

static int number_after(const char *key)
{
    char text[8192];
    ask("/control/stats", text, sizeof text);
    const char *at = strstr(text, key);
    return at ? atoi(at + strlen(key)) : 0;
}

int fault_server_seen(const char *part)
{
    char key[64];
    snprintf(key, sizeof key, "\"%s\": ", part);
    return number_after(key);
}

int fault_server_most(void)
{
    return number_after("\"most\": ");
}

int fault_server_pause(const char *path, int n)
{
    char from[256], text[8192];
    snprintf(from, sizeof from, "/control/pauses%s", path);
    ask(from, text, sizeof text);
    const char *at = strchr(text, '[');
    for (; at && n > 0; n--) at = strchr(at + 1, ',');
    return at && at[1] != ']' ? atoi(at + 1) : -1;
}

void fault_server_sick(const char *kind)
{
    char path[128], text[8192];
    snprintf(path, sizeof path, "/control/sick/%s", kind);
    ask(path, text, sizeof text);
}

void fault_server_down(int down)
{
    char text[8192];
    ask(down ? "/control/down/1" : "/control/down/0", text, sizeof text);
}
