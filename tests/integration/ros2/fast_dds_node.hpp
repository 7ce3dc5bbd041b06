/// \file  Publishers and subscribers of eProsima Fast DDS, the other DDS implementation of ROS 2,
/// on the loopback interface.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include <fastdds/dds/topic/TopicDataType.hpp>

#include "integration/ros2/ros_messages.hpp"

namespace cornerfix::testing {

/// What a QoS profile of rclcpp fixes.
struct FastQos {
  bool is_reliable = true;
  bool is_transient_local = false;
  int depth = 10;
};

inline constexpr FastQos kSensorQos{false, false, 5};
inline constexpr FastQos kReliableQos{};
inline constexpr FastQos kTfQos{true, false, 100};
inline constexpr FastQos kTfStaticQos{true, true, 1};

/// A domain that no other process on this machine is in. It is taken until this is destroyed.
class FreeDomain {
 public:
  FreeDomain();
  ~FreeDomain();
  FreeDomain(const FreeDomain&) = delete;
  FreeDomain& operator=(const FreeDomain&) = delete;

  [[nodiscard]] std::uint32_t id() const { return id_; }

 private:
  std::uint32_t id_ = 0;
  int lock_ = -1;  ///< A bound socket.
};

class FastDdsNode {
 public:
  explicit FastDdsNode(std::uint32_t domain);
  ~FastDdsNode();

  /// Called by threads of the library whenever anything arrives or is matched.
  void on_event(std::function<void()> callback);

  class Writer {
   public:
    virtual ~Writer() = default;
    virtual void write(void* message) = 0;
    [[nodiscard]] virtual int matched() const = 0;
  };

  template <typename Message>
  std::unique_ptr<Writer> advertise(const std::string& topic, const FastQos& qos) {
    return make_writer(make_type<Message>(), topic, qos);
  }

  template <typename Message>
  void subscribe(const std::string& topic, const FastQos& qos,
                 std::function<void(const Message&)> on_message) {
    make_reader(make_type<Message>(), topic, qos,
                [on_message = std::move(on_message)](const void* message) {
                  on_message(*static_cast<const Message*>(message));
                });
  }

 private:
  using Type = eprosima::fastdds::dds::TopicDataType;

  template <typename Message>
  static Type* make_type();

  std::unique_ptr<Writer> make_writer(Type* type, const std::string& topic, const FastQos& qos);
  void make_reader(Type* type, const std::string& topic, const FastQos& qos,
                   std::function<void(const void*)> on_message);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cornerfix::testing
