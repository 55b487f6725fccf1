#pragma once

namespace elastin::lab {

/// The texts of src/report/page/, put into the program when it is built: k_NAME_EXTENSION.
extern const char* const k_page_css;
extern const char* const k_page_js;
extern const char* const k_viewer_js;

}  // namespace elastin::lab
