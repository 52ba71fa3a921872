#pragma once

#include "tetrakis/hier/most_frequent.hpp"
