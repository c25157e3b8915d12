// SPDX-License-Identifier: Apache-2.0
#undef PAGE_NAME
#undef POOL
#undef POOL4
#undef TEXELS
#undef TEXELS4
#undef ZONES
#undef SET_ROOT
#undef SET_ZONES
#undef SET_END
