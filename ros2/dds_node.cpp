#include "ros2/dds_node.hpp"

#include <array>
#include <cstdlib>

namespace cornerfix::ros2 {

namespace {

constexpr std::size_t kTakenAtOnce = 16;

/// Discovery by unicast, since a loopback interface has no multicast by default.
constexpr const char* kLoopbackConfiguration =
    "<CycloneDDS><Domain><General><AllowMulticast>false</AllowMulticast><Interfaces>"
    "<NetworkInterface address=\"127.0.0.1\"/></Interfaces></General><Discovery>"
    "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
    "<Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery></Domain></CycloneDDS>";

/// After the user's own configuration, which Cyclone DDS takes from CYCLONEDDS_URI.
std::string loopback_configuration() {
  const char* own = std::getenv("CYCLONEDDS_URI");
  return own == nullptr ? kLoopbackConfiguration : std::string(own) + "," + kLoopbackConfiguration;
}

Error dds_error(dds_entity_t code, const std::string& where) {
  return {ErrorCode::kUnavailable, std::string("DDS: ") + dds_strretcode(code), where};
}

void take_messages(dds_entity_t reader, void* callback) {
  const auto& on_message = *static_cast<std::function<void(const void*)>*>(callback);
  std::array<void*, kTakenAtOnce> samples{};
  std::array<dds_sample_info_t, kTakenAtOnce> infos{};
  while (true) {
    samples.fill(nullptr);  // Memory is lent by the library.
    const dds_return_t count =
        dds_take(reader, samples.data(), infos.data(), kTakenAtOnce, kTakenAtOnce);
    if (count <= 0) return;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      if (infos[i].valid_data) on_message(samples[i]);
    }
    dds_return_loan(reader, samples.data(), count);
  }
}

}  // namespace

Result<DdsNode> DdsNode::join(std::uint32_t domain, bool is_local_only) {
  const std::string where = "domain " + std::to_string(domain);
  Entity own_domain;
  if (is_local_only) {
    own_domain = Entity(dds_create_domain(domain, loopback_configuration().c_str()));
    if (own_domain.handle() < 0) return dds_error(own_domain.handle(), where);
  }
  Entity participant(dds_create_participant(domain, nullptr, nullptr));
  if (participant.handle() < 0) return dds_error(participant.handle(), where);
  return DdsNode(std::move(own_domain), std::move(participant));
}

Result<Entity> DdsNode::create_topic(const dds_topic_descriptor_t& type, const std::string& name) {
  Entity topic(dds_create_topic(participant_.handle(), &type, name.c_str(), nullptr, nullptr));
  if (topic.handle() < 0) return dds_error(topic.handle(), "topic " + name);
  return topic;
}

Result<void> DdsNode::subscribe(const dds_topic_descriptor_t& type, const std::string& topic,
                                const QosProfile& qos, OnMessage on_message) {
  const Result<Entity> created = create_topic(type, topic);
  if (!created) return created.error();
  callbacks_.push_back(std::make_unique<OnMessage>(std::move(on_message)));
  const std::unique_ptr<dds_listener_t, void (*)(dds_listener_t*)> listener(
      dds_create_listener(callbacks_.back().get()), dds_delete_listener);
  dds_lset_data_available(listener.get(), take_messages);
  const dds_entity_t reader = dds_create_reader(participant_.handle(), created->handle(),
                                                make_qos(qos).get(), listener.get());
  if (reader < 0) return dds_error(reader, "topic " + topic);
  return {};  // The participant deletes the reader.
}

Result<Entity> DdsNode::advertise(const dds_topic_descriptor_t& type, const std::string& topic,
                                  const QosProfile& qos) {
  const Result<Entity> created = create_topic(type, topic);
  if (!created) return created.error();
  Entity writer(
      dds_create_writer(participant_.handle(), created->handle(), make_qos(qos).get(), nullptr));
  if (writer.handle() < 0) return dds_error(writer.handle(), "topic " + topic);
  return writer;
}

}  // namespace cornerfix::ros2
