"""Reports of closed loops and pictures of scans: needs the extra ``report`` (matplotlib and jinja2), and only when called."""

from viewgain.report._report import draw_scan as draw_scan
from viewgain.report._report import draw_scene as draw_scene
from viewgain.report._report import save_scan_picture as save_scan_picture
from viewgain.report._report import write_confidence_picture as write_confidence_picture
from viewgain.report._report import write_coverage_picture as write_coverage_picture
from viewgain.report._report import write_loop_picture as write_loop_picture
from viewgain.report._report import write_map_picture as write_map_picture
from viewgain.report._report import write_ranking_picture as write_ranking_picture
from viewgain.report._report import write_report as write_report
from viewgain.report._report import write_table1_picture as write_table1_picture
from viewgain.report._report import write_training_picture as write_training_picture
