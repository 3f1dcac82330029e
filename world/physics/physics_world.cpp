#include "world/physics/contact.hpp"
