#include "world/physics/contact_generation.hpp"
