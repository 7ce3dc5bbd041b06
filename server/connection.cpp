#include "server/connection.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <utility>

namespace cornerfix::server {

Connection::Connection(int the_socket, SocketName the_client)
    : socket(the_socket), client(std::move(the_client)) {
  const int on = 1;  // Without it an answer on a kept connection may take 40 ms.
  ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

Connection::~Connection() { ::close(socket); }

}  // namespace cornerfix::server
