#include "protocols/net/tls.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <string_view>
#include <sys/stat.h>
#include <utility>

#include <boost/asio/ssl/context.hpp>
#include <fmt/format.h>

namespace aprsim::protocols {
namespace {

namespace ssl = boost::asio::ssl;

template <auto free_one>
struct Free {
  template <typename T>
  void operator()(T* value) const {
    free_one(value);
  }
};
using Certificate = std::unique_ptr<X509, Free<X509_free>>;
using AlternativeNames = std::unique_ptr<GENERAL_NAMES, Free<GENERAL_NAMES_free>>;
using Bio = std::unique_ptr<BIO, Free<BIO_free_all>>;

tl::unexpected<Error> wrong(const std::string& key, const std::string& message) {
  return fail(ErrorCode::kInvalidArgument, key, key + ": " + message);
}

/// The error that OpenSSL reports; empties its list.
std::string complaint() {
  const unsigned long code = ERR_get_error();
  const char* reason = ERR_reason_error_string(code);
  ERR_clear_error();
  return reason == nullptr ? "unknown error" : reason;
}

Result<void> check_readable(const std::string& key, const std::string& path) {
  const std::ifstream in(path);
  if (in) return {};
  return wrong(key, "cannot read " + path + ": " + std::strerror(errno));
}

std::string text_of(const X509_NAME* name) {
  const Bio out(BIO_new(BIO_s_mem()));
  if (!out || X509_NAME_print_ex(out.get(), name, 0, XN_FLAG_RFC2253) < 0) return {};
  char* data = nullptr;
  const auto size = BIO_get_mem_data(out.get(), &data);
  return {data, static_cast<std::size_t>(std::max<long>(size, 0))};
}

std::string text_of(const ASN1_STRING* text) {
  unsigned char* utf8 = nullptr;
  const int size = ASN1_STRING_to_UTF8(&utf8, text);
  if (size < 0) return {};
  std::string out(reinterpret_cast<const char*>(utf8), static_cast<std::size_t>(size));
  OPENSSL_free(utf8);
  return out;
}

std::string address_of(const ASN1_OCTET_STRING* bytes) {
  const int size = ASN1_STRING_length(bytes);
  char text[INET6_ADDRSTRLEN]{};
  const int family = size == 4 ? AF_INET : AF_INET6;
  if (size != 4 && size != 16) return {};
  return inet_ntop(family, ASN1_STRING_get0_data(bytes), text, sizeof text) == nullptr ? "" : text;
}

std::vector<std::string> names_of(X509* certificate) {
  std::vector<std::string> names;
  const X509_NAME* subject = X509_get_subject_name(certificate);
  for (int at = -1; (at = X509_NAME_get_index_by_NID(subject, NID_commonName, at)) >= 0;) {
    names.push_back(text_of(X509_NAME_ENTRY_get_data(X509_NAME_get_entry(subject, at))));
  }
  const AlternativeNames others(static_cast<GENERAL_NAMES*>(
      X509_get_ext_d2i(certificate, NID_subject_alt_name, nullptr, nullptr)));
  for (int i = 0; others && i < sk_GENERAL_NAME_num(others.get()); ++i) {
    const GENERAL_NAME* name = sk_GENERAL_NAME_value(others.get(), i);
    if (name->type == GEN_DNS || name->type == GEN_EMAIL || name->type == GEN_URI) {
      names.push_back(text_of(name->d.ia5));
    } else if (name->type == GEN_IPADD) {
      names.push_back(address_of(name->d.iPAddress));
    }
  }
  std::erase_if(names, [](const std::string& name) {
    // One that goes on behind a zero byte looks like another.
    return name.empty() || name.find('\0') != std::string::npos;
  });
  return names;
}

/// Chooses our protocol among those that the client offers.
int choose_protocol(SSL* /*connection*/, const unsigned char** chosen, unsigned char* chosen_size,
                    const unsigned char* offered, unsigned int offered_size, void* wanted) {
  const auto& ours = *static_cast<const std::string_view*>(wanted);
  unsigned char* found = nullptr;
  if (SSL_select_next_proto(&found, chosen_size,
                            reinterpret_cast<const unsigned char*>(ours.data()),
                            static_cast<unsigned int>(ours.size()), offered,
                            offered_size) != OPENSSL_NPN_NEGOTIATED) {
    return SSL_TLSEXT_ERR_ALERT_FATAL;
  }
  *chosen = found;
  return SSL_TLSEXT_ERR_OK;
}

// Each with its length before it.
constexpr std::string_view kHttp1 = "\x08http/1.1", kHttp2 = "\x02h2";
/// TLS 1.2 without HMAC-SHA-1 and with the suites of.
constexpr const char* kModbusCiphers = "ECDHE+AESGCM:ECDHE+CHACHA20";

/// A key with a password would make the daemon ask on its terminal.
int no_password(char* /*to*/, int /*size*/, int /*writing*/, void* /*unused*/) { return -1; }

Result<void> use_certificate(SSL_CTX* context, const TlsFiles& files) {
  const std::string key = files.section + ".certificate";
  const std::string& path = files.certificate;
  if (auto ok = check_readable(key, path); !ok) return ok;
  if (SSL_CTX_use_certificate_chain_file(context, path.c_str()) != 1) {
    return wrong(key, path + " holds no certificate in PEM: " + complaint());
  }
  const X509* certificate = SSL_CTX_get0_certificate(context);
  if (X509_cmp_current_time(X509_get0_notAfter(certificate)) < 0) {
    return wrong(key, "the certificate in " + path + " has expired");
  }
  if (X509_cmp_current_time(X509_get0_notBefore(certificate)) > 0) {
    return wrong(key, "the certificate in " + path + " does not hold yet");
  }
  return {};
}

Result<void> use_key(SSL_CTX* context, const TlsFiles& files) {
  const std::string key = files.section + ".key";
  if (auto ok = check_readable(key, files.key); !ok) return ok;
  struct stat status {};
  if (stat(files.key.c_str(), &status) == 0 && (status.st_mode & S_IRWXO) != 0) {
    return wrong(key, fmt::format("{} has mode {:03o}, so that everybody reaches it; expected "
                                  "600 or 640",
                                  files.key, status.st_mode & 0777U));
  }
  SSL_CTX_set_default_passwd_cb(context, no_password);
  if (SSL_CTX_use_PrivateKey_file(context, files.key.c_str(), SSL_FILETYPE_PEM) != 1) {
    const std::string why = complaint();
    return wrong(key, why == "key values mismatch"
                          ? files.key + " is not the key of the certificate in " + files.certificate
                          : files.key + " holds no private key in PEM without a password: " + why);
  }
  if (SSL_CTX_check_private_key(context) != 1) {
    return wrong(key, files.key + " is not the key of the certificate in " + files.certificate);
  }
  return {};
}

Result<void> ask_clients(SSL_CTX* context, const TlsFiles& files) {
  if (files.client_ca.empty()) return {};
  const std::string key = files.section + ".client_ca";
  if (auto ok = check_readable(key, files.client_ca); !ok) return ok;
  auto* names = SSL_load_client_CA_file(files.client_ca.c_str());
  if (names == nullptr ||
      SSL_CTX_load_verify_locations(context, files.client_ca.c_str(), nullptr) != 1) {
    return wrong(key, files.client_ca + " holds no certificates in PEM: " + complaint());
  }
  SSL_CTX_set_client_CA_list(context, names);
  SSL_CTX_set_verify(context,
                     SSL_VERIFY_PEER | (files.client_needed ? SSL_VERIFY_FAIL_IF_NO_PEER_CERT : 0),
                     nullptr);
  return {};
}

void speak(SSL_CTX* context, Tls::Protocol protocol) {
  if (protocol == Tls::Protocol::kModbus) {
    // Every OpenSSL has them.
    (void)SSL_CTX_set_cipher_list(context, kModbusCiphers);
    return;
  }
  const std::string_view& wanted = protocol == Tls::Protocol::kHttp2 ? kHttp2 : kHttp1;
  SSL_CTX_set_alpn_select_cb(context, choose_protocol, const_cast<std::string_view*>(&wanted));
}

Result<std::shared_ptr<ssl::context>> make(const TlsFiles& files, Tls::Protocol protocol) {
  auto made = std::make_shared<ssl::context>(ssl::context::tls_server);
  SSL_CTX* context = made->native_handle();
  ERR_clear_error();
  SSL_CTX_set_min_proto_version(context, files.only_tls_1_3 ? TLS1_3_VERSION : TLS1_2_VERSION);
  // A session that is taken up again would keep what a certificate that is over has shown.
  SSL_CTX_set_options(context, SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION | SSL_OP_NO_TICKET |
                                   SSL_OP_CIPHER_SERVER_PREFERENCE);
  SSL_CTX_set_num_tickets(context, 0);
  SSL_CTX_set_session_cache_mode(context, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_mode(context, SSL_MODE_RELEASE_BUFFERS);
  speak(context, protocol);
  if (auto ok = use_certificate(context, files); !ok) return tl::unexpected(ok.error());
  if (auto ok = use_key(context, files); !ok) return tl::unexpected(ok.error());
  if (auto ok = ask_clients(context, files); !ok) return tl::unexpected(ok.error());
  return made;
}

}  // namespace

Result<std::shared_ptr<Tls>> Tls::load(const TlsFiles& files, Protocol protocol) {
  std::shared_ptr<Tls> tls(new Tls(files, protocol));
  if (auto ok = tls->reload(); !ok) return tl::unexpected(ok.error());
  return tls;
}

Result<void> Tls::reload() {
  auto made = make(files_, protocol_);
  if (!made) return tl::unexpected(made.error());
  const std::lock_guard lock(mutex_);
  context_ = std::move(*made);
  return {};
}

std::shared_ptr<ssl::context> Tls::context() const {
  const std::lock_guard lock(mutex_);
  return context_;
}

std::shared_ptr<const ClientCertificate> Tls::client_of(ssl_st* connection) {
  const Certificate certificate(SSL_get1_peer_certificate(connection));
  if (!certificate || SSL_get_verify_result(connection) != X509_V_OK) return nullptr;
  return std::make_shared<const ClientCertificate>(ClientCertificate{
      text_of(X509_get_subject_name(certificate.get())), names_of(certificate.get())});
}

std::string Tls::failure(ssl_st* connection, const std::string& error) {
  ++failures_;
  const long verified = SSL_get_verify_result(connection);
  if (verified == X509_V_OK) return "no TLS handshake: " + error;
  return std::string("its certificate is not taken: ") + X509_verify_cert_error_string(verified);
}

}  // namespace aprsim::protocols
