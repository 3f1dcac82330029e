#include "clients/wires/wire_socket.hpp"

#include <array>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <utility>

namespace aprsim::client {
namespace {

template <auto free_one>
struct FreeBy {
  template <typename T>
  void operator()(T* value) const {
    free_one(value);
  }
};
using Context = std::unique_ptr<SSL_CTX, FreeBy<SSL_CTX_free>>;
using Certificate = std::unique_ptr<X509, FreeBy<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, FreeBy<EVP_PKEY_free>>;
using Bio = std::unique_ptr<BIO, FreeBy<BIO_free_all>>;

int no_password(char* /*to*/, int /*size*/, int /*writing*/, void* /*unused*/) { return -1; }

Bio reader_of(const std::string& pem) {
  return Bio(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
}

/// The error that OpenSSL reports; empties its list.
std::string complaint(const std::string& otherwise) {
  const char* reason = ERR_reason_error_string(ERR_peek_last_error());
  ERR_clear_error();
  return reason == nullptr ? otherwise : reason;
}

bool trust(SSL_CTX* context, const std::string& pem) {
  if (pem.empty()) return SSL_CTX_set_default_verify_paths(context) == 1;
  const Bio in = reader_of(pem);
  int certificates = 0;
  while (const Certificate one{PEM_read_bio_X509(in.get(), nullptr, no_password, nullptr)}) {
    certificates += X509_STORE_add_cert(SSL_CTX_get_cert_store(context), one.get());
  }
  ERR_clear_error();  // of the end of the text
  return certificates > 0;
}

bool show(SSL_CTX* context, const Encryption& own) {
  if (own.certificate.empty()) return true;
  const Bio in = reader_of(own.certificate), key_in = reader_of(own.key);
  const Certificate first(PEM_read_bio_X509(in.get(), nullptr, no_password, nullptr));
  if (!first || SSL_CTX_use_certificate(context, first.get()) != 1) return false;
  while (Certificate next{PEM_read_bio_X509(in.get(), nullptr, no_password, nullptr)}) {
    if (SSL_CTX_add_extra_chain_cert(context, next.get()) == 1) (void)next.release();
  }
  ERR_clear_error();  // of the end of the text
  const Key key(PEM_read_bio_PrivateKey(key_in.get(), nullptr, no_password, nullptr));
  return key && SSL_CTX_use_PrivateKey(context, key.get()) == 1;
}

Outcome<Context> context_of(const Encryption& encryption) {
  Context context(SSL_CTX_new(TLS_client_method()));
  SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION);
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_PEER, nullptr);
  if (!trust(context.get(), encryption.ca)) {
    return failed(FailureKind::kUsage, "the certificate authorities hold no certificate in PEM");
  }
  if (!show(context.get(), encryption)) {
    return failed(FailureKind::kUsage, complaint("the client's certificate or key is no PEM"));
  }
  return context;
}

}  // namespace

void WireSocket::Free::operator()(ssl_st* connection) const { SSL_free(connection); }

Outcome<WireSocket> WireSocket::connect(const std::string& host, std::uint16_t port,
                                        const std::optional<Encryption>& encryption,
                                        Time deadline) {
  auto tcp = TcpSocket::connect(host, port, deadline);
  if (!tcp) return tl::unexpected(tcp.error());
  WireSocket made(*std::move(tcp));
  if (!encryption) return made;
  if (auto begun = made.begin_tls(host, *encryption, deadline); !begun) {
    return tl::unexpected(begun.error());
  }
  return made;
}

Outcome<void> WireSocket::begin_tls(const std::string& host, const Encryption& encryption,
                                    Time deadline) {
  const auto context = context_of(encryption);
  if (!context) return tl::unexpected(context.error());
  tls_.reset(SSL_new(context->get()));
  SSL_set_bio(tls_.get(), BIO_new(BIO_s_mem()), BIO_new(BIO_s_mem()));
  X509_VERIFY_PARAM* checks = SSL_get0_param(tls_.get());
  if (X509_VERIFY_PARAM_set1_ip_asc(checks, host.c_str()) != 1) {
    ERR_clear_error();
    X509_VERIFY_PARAM_set1_host(checks, host.data(), host.size());
    SSL_set_tlsext_host_name(tls_.get(), host.c_str());
  }
  while (true) {
    const int result = SSL_connect(tls_.get());
    if (result == 1) return flush(deadline);
    if (auto ok = go_on(result, deadline); !ok) return ok;
  }
}

Outcome<void> WireSocket::flush(Time deadline) {
  std::array<char, 16384> out{};
  while (true) {
    const int size = BIO_read(SSL_get_wbio(tls_.get()), out.data(), static_cast<int>(out.size()));
    if (size <= 0) return {};
    const auto sent = tcp_.send({out.data(), static_cast<std::size_t>(size)}, deadline);
    if (!sent) return sent;
  }
}

Outcome<void> WireSocket::go_on(int result, Time deadline) {
  const int error = SSL_get_error(tls_.get(), result);
  const auto sent = flush(deadline);
  if (error == SSL_ERROR_ZERO_RETURN) {
    return failed(FailureKind::kConnection, "the connection was closed");
  }
  if (error != SSL_ERROR_WANT_READ) {
    return failed(FailureKind::kConnection, "TLS: " + complaint("the server has ended it"));
  }
  if (!sent) return sent;
  const auto bytes = tcp_.receive(deadline);
  if (!bytes) return tl::unexpected(bytes.error());
  BIO_write(SSL_get_rbio(tls_.get()), bytes->data(), static_cast<int>(bytes->size()));
  return {};
}

Outcome<void> WireSocket::send(std::string_view bytes, Time deadline) {
  if (!tls_) return tcp_.send(bytes, deadline);
  while (!bytes.empty()) {
    const int size = SSL_write(tls_.get(), bytes.data(), static_cast<int>(bytes.size()));
    if (size > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(size));
    } else if (auto ok = go_on(size, deadline); !ok) {
      return ok;
    }
  }
  return flush(deadline);
}

Outcome<std::string> WireSocket::receive(Time deadline) {
  if (!tls_) return tcp_.receive(deadline);
  std::array<char, 16384> in{};
  while (true) {
    const int size = SSL_read(tls_.get(), in.data(), static_cast<int>(in.size()));
    if (size > 0) return std::string(in.data(), static_cast<std::size_t>(size));
    if (auto ok = go_on(size, deadline); !ok) return tl::unexpected(ok.error());
  }
}

}  // namespace aprsim::client
