#pragma once
#include <string_view>

namespace elastin::lab {

/// The texts of src/lab/report/page/, put into the program when it is built: k_NAME_EXTENSION.
extern const char* const k_page_css;
extern const char* const k_body_js;
extern const char* const k_colours_js;
extern const char* const k_marks_js;
extern const char* const k_graphics_painter_js;
extern const char* const k_processor_painter_js;
extern const char* const k_viewer_js;
extern const char* const k_stage_js;
extern const char* const k_plots_js;
extern const char* const k_page_js;

/// Those of src/web/page/.
extern const char* const k_lab_html;
extern const char* const k_lab_css;
extern const char* const k_elastin_js;
extern const char* const k_worker_js;
extern const char* const k_curve_js;
extern const char* const k_settings_js;
extern const char* const k_hand_js;
extern const char* const k_pace_js;
extern const char* const k_bodies_js;
extern const char* const k_lab_js;

/// three, with its notice and the controls that turn a body, as gzip.
extern const std::string_view k_three;

}  // namespace elastin::lab
