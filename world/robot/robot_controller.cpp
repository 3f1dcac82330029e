#include "world/robot/robot_controller.hpp"
