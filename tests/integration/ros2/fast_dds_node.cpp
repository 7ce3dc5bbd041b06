#include "integration/ros2/fast_dds_node.hpp"

#include <arpa/inet.h>
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <atomic>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <stdexcept>
#include <vector>

namespace cornerfix::testing {

namespace {

namespace dds = eprosima::fastdds::dds;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using eprosima::fastrtps::rtps::SerializedPayload_t;

constexpr std::uint32_t kMaxMessageBytes = 1U << 20U;

template <typename T>
T* expect(T* made, const char* what) {
  if (made == nullptr) throw std::runtime_error(std::string("Fast DDS makes no ") + what);
  return made;
}

/// Plain CDR, without a type object, as rmw_fastrtps_cpp has it.
template <typename Message>
class MessageType : public dds::TopicDataType {
 public:
  MessageType() {
    setName(Message::kType);
    m_typeSize = kMaxMessageBytes;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }

  bool serialize(void* data, SerializedPayload_t* payload) override {
    FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->max_size);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    payload->encapsulation = CDR_LE;
    write(cdr, *static_cast<Message*>(data));
    payload->length = static_cast<std::uint32_t>(cdr.getSerializedDataLength());
    return true;
  }

  bool deserialize(SerializedPayload_t* payload, void* data) override {
    FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->length);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    cdr.read_encapsulation();
    static_cast<Message*>(data)->each([&](auto& field) { cdr >> field; });
    return true;
  }

  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] {
      FastBuffer buffer;
      Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
      write(cdr, *static_cast<Message*>(data));
      return static_cast<std::uint32_t>(cdr.getSerializedDataLength());
    };
  }

  void* createData() override { return new Message; }
  void deleteData(void* data) override { delete static_cast<Message*>(data); }
  bool getKey(void* /*data*/, eprosima::fastrtps::rtps::InstanceHandle_t* /*key*/,
              bool /*force_md5*/) override {
    return false;
  }

 private:
  static void write(Cdr& cdr, Message& message) {
    cdr.serialize_encapsulation();
    message.each([&](auto& field) { cdr << field; });
  }
};

template <typename EndpointQos>
EndpointQos endpoint_qos(const FastQos& qos) {
  EndpointQos out;
  out.reliability().kind =
      qos.is_reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
  out.durability().kind =
      qos.is_transient_local ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  out.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  out.history().depth = qos.depth;
  out.endpoint().history_memory_policy = eprosima::fastrtps::rtps::DYNAMIC_RESERVE_MEMORY_MODE;
  return out;
}

std::uint32_t first_port(std::uint32_t domain) { return 7400 + 250 * domain; }

/// On 127.0.0.1 alone, where multicast need not work: others are found by their usual ports.
dds::DomainParticipantQos loopback_qos(std::uint32_t domain) {
  constexpr std::uint32_t kParticipants = 8;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.emplace_back("127.0.0.1");
  dds::DomainParticipantQos qos;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  for (std::uint32_t i = 0; i < kParticipants; ++i) {
    eprosima::fastrtps::rtps::Locator_t peer;
    eprosima::fastrtps::rtps::IPLocator::setIPv4(peer, "127.0.0.1");
    peer.port = first_port(domain) + 10 + 2 * i;  // RTPS 2.5, 9.6.2.3.
    qos.wire_protocol().builtin.initialPeersList.push_back(peer);
  }
  return qos;
}

/// A UDP socket bound to a port of its own; -1 when the port is taken.
int bind_port(int port) {
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_ANY);
  if (::bind(socket, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return socket;
  ::close(socket);
  return -1;
}

/// No participant in the domain has one of the first ports.
bool is_unused(int domain_port) {
  for (const int offset : {0, 1, 10, 11, 12, 13}) {
    const int socket = bind_port(domain_port + offset);
    if (socket < 0) return false;
    ::close(socket);
  }
  return true;
}

class MatchListener : public dds::DataWriterListener {
 public:
  explicit MatchListener(const std::function<void()>& on_event) : on_event_(on_event) {}
  void on_publication_matched(dds::DataWriter* /*writer*/,
                              const dds::PublicationMatchedStatus& status) override {
    matched = status.current_count;
    on_event_();
  }

  std::atomic<int> matched = 0;

 private:
  const std::function<void()>& on_event_;
};

class FastWriter : public FastDdsNode::Writer {
 public:
  FastWriter(const std::function<void()>& on_event, dds::Publisher& publisher, dds::Topic& topic,
             const FastQos& qos)
      : listener_(on_event),
        publisher_(publisher),
        writer_(expect(
            publisher.create_datawriter(&topic, endpoint_qos<dds::DataWriterQos>(qos), &listener_),
            "writer")) {}
  ~FastWriter() override { publisher_.delete_datawriter(writer_); }

  void write(void* message) override { writer_->write(message); }
  [[nodiscard]] int matched() const override { return listener_.matched; }

 private:
  MatchListener listener_;
  dds::Publisher& publisher_;
  dds::DataWriter* writer_;
};

class MessageListener : public dds::DataReaderListener {
 public:
  MessageListener(dds::TypeSupport type, std::function<void(const void*)> on_message,
                  const std::function<void()>& on_event)
      : type_(std::move(type)), on_message_(std::move(on_message)), on_event_(on_event) {}

  void on_data_available(dds::DataReader* reader) override {
    dds::SampleInfo info;
    void* message = type_->createData();
    while (reader->take_next_sample(message, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) on_message_(message);
    }
    type_->deleteData(message);
    on_event_();
  }

 private:
  dds::TypeSupport type_;
  std::function<void(const void*)> on_message_;
  const std::function<void()>& on_event_;
};

}  // namespace

FreeDomain::FreeDomain() {
  // Ports of higher domains are among those that the system gives to clients.
  constexpr int kFirst = 1;
  constexpr int kLast = 100;
  constexpr int kUnusedOffset = 249;  // Of the last participant that nobody has.
  for (int id = kFirst; id <= kLast; ++id) {
    const int domain_port = static_cast<int>(first_port(static_cast<std::uint32_t>(id)));
    lock_ = bind_port(domain_port + kUnusedOffset);
    if (lock_ >= 0 && is_unused(domain_port)) {
      id_ = static_cast<std::uint32_t>(id);
      return;
    }
    if (lock_ >= 0) ::close(lock_);
  }
  throw std::runtime_error("all DDS domains from 1 to 100 are in use");
}

FreeDomain::~FreeDomain() { ::close(lock_); }

struct FastDdsNode::Impl {
  // Listeners are called until their participant is deleted.
  std::function<void()> on_event = [] {};
  std::vector<std::unique_ptr<MessageListener>> listeners;
  dds::DomainParticipant* participant = nullptr;
  dds::Publisher* publisher = nullptr;
  dds::Subscriber* subscriber = nullptr;

  dds::Topic& topic(const dds::TypeSupport& type, const std::string& name) const {
    type.register_type(participant);
    return *expect(participant->create_topic(name, type.get_type_name(), dds::TOPIC_QOS_DEFAULT),
                   "topic");
  }
};

FastDdsNode::FastDdsNode(std::uint32_t domain) : impl_(std::make_unique<Impl>()) {
  impl_->participant = expect(dds::DomainParticipantFactory::get_instance()->create_participant(
                                  domain, loopback_qos(domain)),
                              "participant");
  impl_->publisher =
      expect(impl_->participant->create_publisher(dds::PUBLISHER_QOS_DEFAULT), "publisher");
  impl_->subscriber =
      expect(impl_->participant->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT), "subscriber");
}

FastDdsNode::~FastDdsNode() {
  impl_->participant->delete_contained_entities();
  dds::DomainParticipantFactory::get_instance()->delete_participant(impl_->participant);
}

void FastDdsNode::on_event(std::function<void()> callback) {
  impl_->on_event = std::move(callback);
}

template <typename Message>
FastDdsNode::Type* FastDdsNode::make_type() {
  return new MessageType<Message>;
}
template FastDdsNode::Type* FastDdsNode::make_type<ros::LaserScan>();
template FastDdsNode::Type* FastDdsNode::make_type<ros::Odometry>();
template FastDdsNode::Type* FastDdsNode::make_type<ros::TfMessage>();
template FastDdsNode::Type* FastDdsNode::make_type<ros::PoseWithCovarianceStamped>();
template FastDdsNode::Type* FastDdsNode::make_type<ros::DiagnosticArray>();

std::unique_ptr<FastDdsNode::Writer> FastDdsNode::make_writer(Type* type, const std::string& topic,
                                                              const FastQos& qos) {
  return std::make_unique<FastWriter>(impl_->on_event, *impl_->publisher,
                                      impl_->topic(dds::TypeSupport(type), topic), qos);
}

void FastDdsNode::make_reader(Type* type, const std::string& topic, const FastQos& qos,
                              std::function<void(const void*)> on_message) {
  const dds::TypeSupport support(type);
  impl_->listeners.push_back(
      std::make_unique<MessageListener>(support, std::move(on_message), impl_->on_event));
  expect(impl_->subscriber->create_datareader(&impl_->topic(support, topic),
                                              endpoint_qos<dds::DataReaderQos>(qos),
                                              impl_->listeners.back().get()),
         "reader");
}

}  // namespace cornerfix::testing
