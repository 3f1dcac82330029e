#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "protocols/access/access.hpp"
#include "world/base/result.hpp"

namespace boost::asio::ssl {
class context;
}
struct ssl_st;

namespace aprsim::protocols {

/// The files of a listener's certificate and of its clients' authorities, in PEM.
struct TlsFiles {
  std::string certificate;      ///< followed by its intermediate certificates
  std::string key;              ///< without a password, and not readable by everybody
  std::string client_ca = {};   ///< authorities of clients' certificates; empty = none is requested
  bool client_needed = false;   ///< refuse clients without a certificate
  bool only_tls_1_3 = false;    ///< refuse TLS 1.2, too
  std::string section = "tls";  ///< of the configuration, for errors
};

/// How the connections of a listener are encrypted: TLS 1.2 or 1.3, by OpenSSL. Thread: any.
class Tls {
 public:
  /// Modbus: the cipher suites that MODBUS/TCP Security v3.6 allows (10.2), with forward secrecy.
  enum class Protocol : std::uint8_t { kHttp1, kHttp2, kModbus };

  /// Errors name key, file and fault: unreadable, no certificate, expired, a key of another
  /// certificate.
  [[nodiscard]] static Result<std::shared_ptr<Tls>> load(const TlsFiles& files, Protocol protocol);

  /// Reads the files again, for connections from now on. An error changes nothing.
  [[nodiscard]] Result<void> reload();
  /// For a connection that begins now.
  [[nodiscard]] std::shared_ptr<boost::asio::ssl::context> context() const;

  /// The certificate that the client has shown in a finished handshake; null = none.
  [[nodiscard]] static std::shared_ptr<const ClientCertificate> client_of(ssl_st* connection);
  /// Counts a failed handshake and describes its cause.
  [[nodiscard]] std::string failure(ssl_st* connection, const std::string& error);
  [[nodiscard]] std::uint64_t failures() const { return failures_; }

 private:
  Tls(TlsFiles files, Protocol protocol) : files_(std::move(files)), protocol_(protocol) {}

  const TlsFiles files_;
  const Protocol protocol_;
  mutable std::mutex mutex_;
  std::shared_ptr<boost::asio::ssl::context> context_;
  std::atomic<std::uint64_t> failures_{0};
};

}  // namespace aprsim::protocols
