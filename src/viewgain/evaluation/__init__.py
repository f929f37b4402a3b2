"""How good choices of views are, beside what answers without learning get (the paper's Table 1); docs/evaluation.md."""

from viewgain.evaluation._bootstrap import Shares as Shares
from viewgain.evaluation._bootstrap import difference_by_object as difference_by_object
from viewgain.evaluation._bootstrap import shares_by_object as shares_by_object
from viewgain.evaluation._judged import SPLITS as SPLITS
from viewgain.evaluation._judged import Judged as Judged
from viewgain.evaluation._judged import judged_rows as judged_rows
from viewgain.evaluation._judged import learned_rows as learned_rows
from viewgain.evaluation._judged import read_judged as read_judged
from viewgain.evaluation._markdown import to_markdown as to_markdown
from viewgain.evaluation._scored import Scored as Scored
from viewgain.evaluation._scored import scored as scored
from viewgain.evaluation._table1 import RESERVED as RESERVED
from viewgain.evaluation._table1 import Difference as Difference
from viewgain.evaluation._table1 import Row as Row
from viewgain.evaluation._table1 import Table1 as Table1
from viewgain.evaluation._table1 import table1 as table1
