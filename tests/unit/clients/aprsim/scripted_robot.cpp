#include "tests/unit/clients/aprsim/scripted_robot.hpp"

#include <arpa/inet.h>
#include <stdexcept>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

#include "crcl/command_codec.hpp"
#include "crcl/status_codec.hpp"

namespace aprsim::test {

ScriptedRobot::ScriptedRobot(Script script, std::int64_t last_id) : script_(std::move(script)) {
  now_.command_id = last_id;
  now_.state = crcl::CommandState::kDone;
  next_ = now_;
  listen_fd_ = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  if (bind(listen_fd_, reinterpret_cast<const sockaddr*>(&address), size) != 0 ||
      listen(listen_fd_, 8) != 0 ||
      getsockname(listen_fd_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    throw std::runtime_error("no port for the scripted robot");
  }
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { serve(); });
}

ScriptedRobot::~ScriptedRobot() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    shutdown(listen_fd_, SHUT_RDWR);
    if (client_fd_ >= 0) shutdown(client_fd_, SHUT_RDWR);
  }
  thread_.join();
  close(listen_fd_);
}

std::vector<crcl::Command> ScriptedRobot::commands() const {
  const std::lock_guard lock(mutex_);
  return commands_;
}

void ScriptedRobot::serve() {
  while (true) {
    const int fd = accept(listen_fd_, nullptr, nullptr);
    if (fd < 0) return;
    const bool begun = begin(fd);
    if (begun) talk(fd);
    end(fd);
    if (!begun) return;
  }
}

bool ScriptedRobot::begin(int fd) {
  const std::lock_guard lock(mutex_);
  if (stopping_) return false;
  client_fd_ = fd;
  return true;
}

// Closed under the lock: the destructor must not meet another socket under the same number.
void ScriptedRobot::end(int fd) {
  const std::lock_guard lock(mutex_);
  client_fd_ = -1;
  close(fd);
}

void ScriptedRobot::talk(int fd) {
  auto framer = crcl::Framer::for_commands();
  char buffer[4096];
  for (ssize_t size = 0; (size = recv(fd, buffer, sizeof buffer, 0)) > 0;) {
    framer.append({buffer, static_cast<std::size_t>(size)});
    for (auto document = framer.next(); document && *document; document = framer.next()) {
      const auto instance = crcl::decode_command(**document);
      if (!instance) return;
      const auto& command = instance->command;
      if (std::holds_alternative<crcl::GetStatus>(command.body)) {
        const std::string reply = answer();
        if (send(fd, reply.data(), reply.size(), MSG_NOSIGNAL) < 0) return;
        continue;
      }
      const std::lock_guard lock(mutex_);
      commands_.push_back(command);
      now_ = {.command_id = command.id, .state = crcl::CommandState::kWorking};
      next_ = script_(command);
    }
  }
}

std::string ScriptedRobot::answer() {
  const std::lock_guard lock(mutex_);
  crcl::Status status;
  status.command = std::exchange(now_, next_);
  for (int joint = 1; joint <= 6; ++joint) status.joints.push_back({joint, 10.0 * joint, {}, {}});
  status.pose = crcl::PoseStatus{{{300, 0, 400}, {1, 0, 0}, {0, 0, -1}}, {}, {}, {}};
  return crcl::encode_status(status);
}

}  // namespace aprsim::test
