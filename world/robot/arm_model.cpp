#include "world/robot/arm_model.hpp"
