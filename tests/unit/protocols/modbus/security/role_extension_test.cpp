#include "protocols/modbus/security/role_extension.hpp"

#include <memory>
#include <openssl/x509.h>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace aprsim::modbus_server {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// A UTF8String in DER, written independently of OpenSSL.
Bytes der(const std::string& text) {
  Bytes bytes{0x0C};
  if (text.size() >= 256) {
    bytes.insert(bytes.end(), {0x82, static_cast<std::uint8_t>(text.size() >> 8U)});
  } else if (text.size() >= 128) {
    bytes.push_back(0x81);
  }
  bytes.push_back(static_cast<std::uint8_t>(text.size() & 0xFFU));
  bytes.insert(bytes.end(), text.begin(), text.end());
  return bytes;
}

/// Printable characters of one to four bytes.
std::string random_text(std::mt19937& random, std::size_t max_size) {
  const std::vector<std::string> letters{
      "a", "Z", "7", " ", "-", "\xC3\xA9", "\xE2\x82\xAC", "\xF0\x9F\x94\x91"};
  std::string text = "r";
  const std::size_t size = 1 + random() % max_size;
  while (true) {
    const std::string& letter = letters[random() % letters.size()];
    if (text.size() + letter.size() > size) return text;
    text += letter;
  }
}

struct FreeOne {
  void operator()(X509* certificate) const { X509_free(certificate); }
};
using Certificate = std::unique_ptr<X509, FreeOne>;

Certificate certificate_with(const std::vector<Bytes>& roles) {
  Certificate certificate(X509_new());
  for (const Bytes& content : roles) {
    ASN1_OBJECT* oid = OBJ_txt2obj(kRoleOid, 1);
    ASN1_OCTET_STRING* octets = ASN1_OCTET_STRING_new();
    ASN1_OCTET_STRING_set(octets, content.data(), static_cast<int>(content.size()));
    X509_EXTENSION* extension = X509_EXTENSION_create_by_OBJ(nullptr, oid, 0, octets);
    X509_add_ext(certificate.get(), extension, -1);
    X509_EXTENSION_free(extension);
    ASN1_OCTET_STRING_free(octets);
    ASN1_OBJECT_free(oid);
  }
  return certificate;
}

TEST(RoleExtension, IsTheWholeTextOfAUtf8String) {
  EXPECT_EQ(role_in(der("Operator")).value(), "Operator");
  EXPECT_EQ(role_in(der("view,operate")).value(), "view,operate") << "one role";
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    const std::string text = random_text(random, kMaxRoleSize);
    ASSERT_EQ(role_in(der(text)).value_or(""), text);
  }
}

TEST(RoleExtension, RefusesEveryOtherLength) {
  std::mt19937 random(2);
  for (int i = 0; i < 200; ++i) {
    const Bytes whole = der(random_text(random, 40));
    for (std::size_t size = 0; size < whole.size(); ++size) {
      EXPECT_FALSE(role_in(std::span(whole).first(size))) << size;
    }
    Bytes longer = whole;
    longer.push_back(static_cast<std::uint8_t>(random()));
    EXPECT_FALSE(role_in(longer));
  }
  EXPECT_TRUE(role_in(der(std::string(kMaxRoleSize, 'r'))));
  EXPECT_FALSE(role_in(der(std::string(kMaxRoleSize + 1, 'r'))));
}

TEST(RoleExtension, RefusesHostileEncodings) {
  for (const Bytes& bytes : {
           Bytes{},
           Bytes{0x0C, 0},                                  // empty
           Bytes{0x0C, 0x81, 1, 'x'},                       // longer length than needed
           Bytes{0x0C, 0x84, 0, 0, 0, 1, 'x'},              //
           Bytes{0x0C, 0x84, 0xFF, 0xFF, 0xFF, 0xFF, 'x'},  // a length beyond the end
           Bytes{0x0C, 0x88, 1, 2, 3, 4, 5, 6, 7, 8, 'x'},  //
           Bytes{0x2C, 0x80, 0x0C, 1, 'x', 0, 0},           // constructed, indefinite
           Bytes{0x2C, 3, 0x0C, 1, 'x'},                    // constructed
           Bytes{0x13, 1, 'x'},                             // PrintableString
           Bytes{0x16, 1, 'x'},                             // IA5String
           Bytes{0x04, 1, 'x'},                             // OCTET STRING
           Bytes{'O', 'p', 'e', 'r', 'a', 't', 'o', 'r'},   // bare text
           Bytes{0x0C, 2, 'a', 0},
           Bytes{0x0C, 2, 'a', '\n'},
           Bytes{0x0C, 2, 'a', 0x7F},
           Bytes{0x0C, 2, 0xC0, 0x80},        // overlong zero
           Bytes{0x0C, 3, 0xED, 0xA0, 0x80},  // surrogate
           Bytes{0x0C, 1, 0xFF},
           Bytes{0x0C, 2, 'a', 0xC3},  // no UTF-8
       }) {
    EXPECT_FALSE(role_in(bytes)) << ::testing::PrintToString(bytes);
  }
}

TEST(RoleExtension, AcceptsNoBytesButTheDerOfTheRole) {
  std::mt19937 random(3);
  int accepted = 0;
  for (int i = 0; i < 200'000; ++i) {
    Bytes bytes = der(random_text(random, 12));
    for (std::size_t n = random() % 3; n > 0; --n) {
      bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    }
    const auto role = role_in(bytes);
    if (!role) continue;
    ++accepted;
    ASSERT_EQ(der(*role), bytes);
  }
  EXPECT_GT(accepted, 60'000);
  EXPECT_LT(accepted, 190'000);
}

TEST(RoleExtension, StandsOnceInACertificate) {
  EXPECT_EQ(role_of(certificate_with({}).get()).value(), std::nullopt);
  EXPECT_EQ(role_of(certificate_with({der("Operator")}).get()).value(), "Operator");
  const auto two = role_of(certificate_with({der("Operator"), der("Operator")}).get());
  ASSERT_FALSE(two);
  EXPECT_EQ(two.error().message, "the role in its certificate is not the only one");
  EXPECT_FALSE(role_of(certificate_with({Bytes{0x13, 1, 'x'}}).get()));
  EXPECT_FALSE(role_of(certificate_with({Bytes{}}).get()));
}

}  // namespace
}  // namespace aprsim::modbus_server
