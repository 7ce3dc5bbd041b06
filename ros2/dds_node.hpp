/// \file  A participant in a DDS domain, with its subscriptions and publishers.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <cornerfix/result.hpp>

#include "ros2/messages.hpp"
#include "ros2/qos.hpp"

namespace cornerfix::ros2 {

/// A DDS entity, deleted with all that belongs to it.
class Entity {
 public:
  Entity() = default;
  explicit Entity(dds_entity_t handle) : handle_(handle) {}
  Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Entity() {
    if (handle_ > 0) dds_delete(handle_);
  }

  [[nodiscard]] dds_entity_t handle() const { return handle_; }

 private:
  dds_entity_t handle_ = 0;
};

/// Writes messages of one topic. Thread-safe.
template <typename Message>
class Publisher {
 public:
  Publisher() = default;
  explicit Publisher(Entity writer) : writer_(std::move(writer)) {}

  void publish(const Message& message) { dds_write(writer_.handle(), &message); }

  [[nodiscard]] bool has_subscriber() const {
    dds_publication_matched_status_t status{};
    dds_get_publication_matched_status(writer_.handle(), &status);
    return status.current_count > 0;
  }

 private:
  Entity writer_;
};

/// Not synchronised; callbacks come from threads of the DDS library, one after the other per topic,
/// until the node is destroyed.
class DdsNode {
 public:
  /// \param is_local_only  Use the loopback interface only, as with ROS_LOCALHOST_ONLY=1.
  [[nodiscard]] static Result<DdsNode> join(std::uint32_t domain, bool is_local_only);

  /// \param topic  As on the wire: see dds_topic().
  template <typename Message>
  [[nodiscard]] Result<void> subscribe(const std::string& topic, const QosProfile& qos,
                                       std::function<void(const Message&)> on_message) {
    return subscribe(descriptor<Message>(), topic, qos,
                     [on_message = std::move(on_message)](const void* message) {
                       on_message(*static_cast<const Message*>(message));
                     });
  }

  template <typename Message>
  [[nodiscard]] Result<Publisher<Message>> advertise(const std::string& topic,
                                                     const QosProfile& qos) {
    Result<Entity> writer = advertise(descriptor<Message>(), topic, qos);
    if (!writer) return writer.error();
    return Publisher<Message>(std::move(*writer));
  }

 private:
  using OnMessage = std::function<void(const void*)>;

  DdsNode(Entity domain, Entity participant)
      : domain_(std::move(domain)), participant_(std::move(participant)) {}

  [[nodiscard]] Result<Entity> create_topic(const dds_topic_descriptor_t& type,
                                            const std::string& name);
  [[nodiscard]] Result<void> subscribe(const dds_topic_descriptor_t& type, const std::string& topic,
                                       const QosProfile& qos, OnMessage on_message);
  [[nodiscard]] Result<Entity> advertise(const dds_topic_descriptor_t& type,
                                         const std::string& topic, const QosProfile& qos);

  // The readers call back until they are deleted, so what they call is deleted after them.
  std::vector<std::unique_ptr<OnMessage>> callbacks_;
  Entity domain_;  ///< Only where its configuration is ours.
  Entity participant_;
};

}  // namespace cornerfix::ros2
