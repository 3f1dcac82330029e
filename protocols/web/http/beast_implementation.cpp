// Beast, compiled here once instead of in every file that uses it.

#include <boost/beast/src.hpp>
