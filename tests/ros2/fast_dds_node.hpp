#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/builtin/data/ReaderProxyData.h>
#include <fastdds/rtps/builtin/data/WriterProxyData.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

namespace aprsim::test {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

/// A type of which only the name is known: its samples are the serialized bytes.
class BytesType : public dds::TopicDataType {
 public:
  explicit BytesType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 1 << 20;
    m_isGetKeyDefined = false;
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<std::vector<unsigned char>*>(data);
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    payload->encapsulation = CDR_LE;
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    static_cast<std::vector<unsigned char>*>(data)->assign(payload->data,
                                                           payload->data + payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] {
      return static_cast<std::uint32_t>(static_cast<std::vector<unsigned char>*>(data)->size());
    };
  }
  void* createData() override { return new std::vector<unsigned char>; }
  void deleteData(void* data) override { delete static_cast<std::vector<unsigned char>*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

/// The fields of a sample in the order of its type, in the little-endian CDR of RTPS 2.
class CdrReader {
 public:
  explicit CdrReader(const std::vector<unsigned char>& bytes) : bytes_(bytes) {
    if (bytes_.at(1) != 1) throw std::runtime_error("expected little-endian CDR");
  }
  template <typename T>
  T number() {
    at_ = (at_ + sizeof(T) - 1) / sizeof(T) * sizeof(T);
    T value;
    if (kHeader + at_ + sizeof(T) > bytes_.size()) throw std::runtime_error("sample is too short");
    std::memcpy(&value, bytes_.data() + kHeader + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  std::string text() {
    const auto length = number<std::uint32_t>();  // with the zero at its end
    std::string value;
    for (std::uint32_t i = 0; i < length; ++i) value += number<char>();
    value.pop_back();
    return value;
  }
  std::vector<std::string> texts() {
    std::vector<std::string> values(number<std::uint32_t>());
    for (auto& value : values) value = text();
    return values;
  }
  std::vector<double> doubles() {
    std::vector<double> values(number<std::uint32_t>());
    for (auto& value : values) value = number<double>();
    return values;
  }
  /// A builtin_interfaces/msg/Time, in seconds.
  double time() {
    const double s = number<std::int32_t>();
    return s + 1e-9 * number<std::uint32_t>();
  }
  [[nodiscard]] bool at_end() const { return kHeader + (at_ + 3) / 4 * 4 >= bytes_.size(); }

 private:
  static constexpr std::size_t kHeader = 4;
  const std::vector<unsigned char>& bytes_;
  std::size_t at_ = 0;
};

/// The bytes of a sample, field by field, in the little-endian CDR of RTPS 2.
class CdrWriter {
 public:
  template <typename T>
  CdrWriter& number(T value) {
    while ((bytes_.size() - kHeader) % sizeof(T) != 0) bytes_.push_back(0);
    const auto* from = reinterpret_cast<const unsigned char*>(&value);
    bytes_.insert(bytes_.end(), from, from + sizeof(T));
    return *this;
  }
  CdrWriter& text(const std::string& value) {
    number(static_cast<std::uint32_t>(value.size() + 1));
    bytes_.insert(bytes_.end(), value.begin(), value.end());
    bytes_.push_back(0);
    return *this;
  }
  CdrWriter& texts(const std::vector<std::string>& values) {
    number(static_cast<std::uint32_t>(values.size()));
    for (const auto& value : values) text(value);
    return *this;
  }
  CdrWriter& doubles(const std::vector<double>& values) {
    number(static_cast<std::uint32_t>(values.size()));
    for (const double value : values) number(value);
    return *this;
  }
  /// A builtin_interfaces/msg/Time or Duration.
  CdrWriter& time(double value_s) {
    const double whole = std::floor(value_s);
    number(static_cast<std::int32_t>(whole));
    return number(static_cast<std::uint32_t>(std::lround(1e9 * (value_s - whole))));
  }
  [[nodiscard]] const std::vector<unsigned char>& bytes() const { return bytes_; }

 private:
  static constexpr std::size_t kHeader = 4;
  std::vector<unsigned char> bytes_ = {0, 1, 0, 0};
};

/// A participant of Fast DDS on the loopback, without multicast.
class FastDdsNode : private dds::DomainParticipantListener {
 public:
  struct Endpoint {
    std::string type;
    std::string user_data;
    bool reliable = false;
    bool transient_local = false;
  };

  explicit FastDdsNode(unsigned domain) {
    dds::DomainParticipantQos qos;
    qos.transport().use_builtin_transports = false;
    const auto transport = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    transport->interfaceWhiteList.push_back("127.0.0.1");
    qos.transport().user_transports.push_back(transport);
    for (std::uint32_t participant = 0; participant < 8; ++participant) {
      rtps::Locator_t peer;
      rtps::IPLocator::setIPv4(peer, 127, 0, 0, 1);
      peer.port = 7400 + 250 * domain + 10 + 2 * participant;  // RTPS 2.3, section 9.6.1.1
      qos.wire_protocol().builtin.initialPeersList.push_back(peer);
    }
    participant_ = dds::DomainParticipantFactory::get_instance()->create_participant(
        domain, qos, this, dds::StatusMask::none());
    if (!participant_) throw std::runtime_error("Fast DDS makes no participant");
    subscriber_ = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
    publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
  }
  ~FastDdsNode() override {
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  /// The writers discovered so far, by the name of their topic.
  std::map<std::string, Endpoint> writers() {
    const std::lock_guard lock(mutex_);
    return writers_;
  }
  /// The same of readers.
  std::map<std::string, Endpoint> readers() {
    const std::lock_guard lock(mutex_);
    return found_readers_;
  }

  void subscribe(const std::string& topic, const std::string& type, bool transient_local,
                 const std::string& user_data = {}, bool reliable = true) {
    auto* description = make_topic(topic, type);
    dds::DataReaderQos qos;
    qos.user_data().setValue({user_data.begin(), user_data.end()});
    qos.reliability().kind =
        reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
    qos.durability().kind =
        transient_local ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
    qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = 10;
    readers_[topic] = subscriber_->create_datareader(description, qos);
  }

  /// Prepares write().
  void advertise(const std::string& topic, const std::string& type, const std::string& user_data) {
    auto* description = make_topic(topic, type);
    dds::DataWriterQos qos;
    qos.user_data().setValue({user_data.begin(), user_data.end()});
    qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
    qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = 10;
    written_[topic] = publisher_->create_datawriter(description, qos);
  }
  /// Whether a topic that is advertised or subscribed has a peer.
  bool is_matched(const std::string& topic) {
    if (written_.contains(topic)) {
      dds::PublicationMatchedStatus status;
      written_.at(topic)->get_publication_matched_status(status);
      return status.current_count > 0;
    }
    dds::SubscriptionMatchedStatus status;
    readers_.at(topic)->get_subscription_matched_status(status);
    return status.current_count > 0;
  }
  void write(const std::string& topic, std::vector<unsigned char> sample) {
    if (!written_.at(topic)->write(&sample)) throw std::runtime_error("cannot write " + topic);
  }

  /// The next sample of a subscribed topic; empty = there is none.
  std::vector<unsigned char> take(const std::string& topic) {
    std::vector<unsigned char> sample;
    dds::SampleInfo info;
    while (readers_.at(topic)->take_next_sample(&sample, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) return sample;
    }
    return {};
  }

 private:
  dds::Topic* make_topic(const std::string& topic, const std::string& type) {
    dds::TypeSupport(new BytesType(type)).register_type(participant_);
    return participant_->create_topic(topic, type, dds::TOPIC_QOS_DEFAULT);
  }

  template <typename Data>
  static Endpoint endpoint_of(const Data& data) {
    const auto bytes = data.m_qos.m_userData.getValue();
    return {data.typeName().c_str(), std::string(bytes.begin(), bytes.end()),
            data.m_qos.m_reliability.kind == dds::RELIABLE_RELIABILITY_QOS,
            data.m_qos.m_durability.kind == dds::TRANSIENT_LOCAL_DURABILITY_QOS};
  }
  void on_publisher_discovery(dds::DomainParticipant*, rtps::WriterDiscoveryInfo&& info) override {
    const std::lock_guard lock(mutex_);
    writers_[info.info.topicName().c_str()] = endpoint_of(info.info);
  }
  void on_subscriber_discovery(dds::DomainParticipant*, rtps::ReaderDiscoveryInfo&& info) override {
    const std::lock_guard lock(mutex_);
    found_readers_[info.info.topicName().c_str()] = endpoint_of(info.info);
  }

  dds::DomainParticipant* participant_ = nullptr;
  dds::Subscriber* subscriber_ = nullptr;
  dds::Publisher* publisher_ = nullptr;
  std::map<std::string, dds::DataReader*> readers_;
  std::map<std::string, dds::DataWriter*> written_;
  std::mutex mutex_;
  std::map<std::string, Endpoint> writers_, found_readers_;
};

}  // namespace aprsim::test
