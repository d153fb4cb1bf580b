/* Print a TCP port of loopback on which nobody is listening. */
#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdio.h>
#include <sys/socket.h>

int main(void)
{
    struct sockaddr_in name = {.sin_family = AF_INET, .sin_addr = {htonl(INADDR_LOOPBACK)}};
    socklen_t size = sizeof(name);
    int fd = socket(AF_INET, SOCK_STREAM, 0);

    if (fd < 0 || bind(fd, (struct sockaddr *)&name, size) ||
        getsockname(fd, (struct sockaddr *)&name, &size))
        return 1;
    printf("%d\n", ntohs(name.sin_port));
    return 0;
}
