#include "world/scene/scene.hpp"
