// Errors of devices in a scene, and of their libraries.

#include <ostream>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/unit/world/devices/device_scene.hpp"
#include "world/devices/device_group.hpp"
#include "world/devices/extension.hpp"

namespace aprsim::test {
namespace {

struct Case {
  const char* name;
  const char* device;  ///< below `devices`, from line 3 of the scene on
  const char* error;
};
std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.name; }

class DeviceSetup : public testing::TestWithParam<Case> {};

TEST_P(DeviceSetup, NamesPlaceValueAndExpectation) {
  const auto scene = scene_with(GetParam().device);
  const auto checked = devices::check_devices(*scene, "mine.yaml");
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().message, std::string("mine.yaml:") + GetParam().error);
  EXPECT_THROW(world::World(scene, 1), std::runtime_error);
}

INSTANTIATE_TEST_SUITE_P(
    Parameters, DeviceSetup,
    testing::Values(
        Case{"missing", "  - {name: s, extension: scale}\n",
             "3:26: devices[0].extension: device s lacks the parameter low_m, which the extension "
             "needs"},
        Case{"no_list", "  - {name: s, extension: scale, parameters: {low_m: 1}}\n",
             "3:53: devices[0].parameters.low_m: found \"1\", expected a list of 3 numbers"},
        Case{"short_list", "  - {name: s, extension: scale, parameters: {low_m: [1, 2]}}\n",
             "3:53: devices[0].parameters.low_m: found a list of 2, expected a list of 3 numbers"},
        Case{"no_number", "  - {name: s, extension: scale, parameters: {low_m: [1, 2, x]}}\n",
             "3:53: devices[0].parameters.low_m: found \"x\", expected a number"},
        Case{"out_of_range",
             "  - {name: s, extension: scale, parameters: {low_m: [0, 0, 0], high_m: [1, 1, 1],\n"
             "     settling_s: 99}}\n",
             "4:18: devices[0].parameters.settling_s: found 99, expected a number in [0.001, 60]"},
        Case{"unknown",
             "  - {name: s, extension: scale, parameters: {low_m: [0, 0, 0], high_m: [1, 1, 1],\n"
             "     colour: red}}\n",
             "4:14: devices[0].parameters.colour: found an unknown parameter, expected one of "
             "full_kg, high_m, low_m, settling_s, which extension scale reads"},
        Case{"no_flag", "  - {name: m, extension: mover, parameters: {action: none, once: 1}}\n",
             "3:66: devices[0].parameters.once: found \"1\", expected true or false"},
        Case{"no_body",
             "  - {name: m, extension: mover, parameters: {action: push, body: gear_9}}\n",
             "3:66: devices[0].parameters.body: found \"gear_9\", expected the name of a body: "
             "small_gear_vessel_1"},
        Case{"constructor", "  - {name: t, extension: trouble, parameters: {kind: constructor}}\n",
             "3:26: devices[0].extension: device t: no licence"}),
    [](const auto& test) { return std::string(test.param.name); });

std::string load_error(const std::string& name) {
  const std::vector<std::string> directories = {"/nowhere", APRSIM_EXTENSIONS};
  const auto loaded = devices::Extension::load(name, directories);
  return loaded ? "" : loaded.error().message;
}

TEST(ExtensionLibraries, AreFoundByNameInTheirDirectoriesOnly) {
  EXPECT_EQ(load_error("scale"), "");
  EXPECT_EQ(load_error("scales"),
            "no libscales.so in the directories of extensions (option --extensions); extensions "
            "there: mover, outdated, pusher, scale, text, trouble, unrelated");
  const std::vector<std::string> directories = {APRSIM_EXTENSIONS};
  for (const char* name : {"../extensions/libscale", "/etc/passwd", "", ".", "scale.so"}) {
    EXPECT_EQ(devices::find_extension(name, directories), "") << name;
  }
}

TEST(ExtensionLibraries, OtherVersionsAndLibrariesAreRefused) {
  EXPECT_EQ(load_error("outdated"),
            "liboutdated.so was built for version 0 of the interface of devices, this program has "
            "version 2; build it again");
  EXPECT_EQ(load_error("unrelated"),
            "libunrelated.so is no extension: it lacks APRSIM_EXTENSION(CLASS)");
  const std::string text = load_error("text");
  EXPECT_TRUE(text.starts_with("libtext.so cannot be loaded: libtext.so: ")) << text;
  EXPECT_EQ(text.find(APRSIM_EXTENSIONS), std::string::npos) << text;
}

TEST(ExtensionLibraries, ASceneNamesNoPath) {
  for (const char* name : {"../scale", "/tmp/libscale.so", "'a b'"}) {
    const std::string device = std::string("  - {name: s, extension: ") + name + "}\n";
    try {
      (void)scene_with(device);
      ADD_FAILURE() << name;
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find("expected the name of an extension"),
                std::string::npos)
          << error.what();
    }
  }
}

}  // namespace
}  // namespace aprsim::test
