"""Objects made by recipe from a random generator: unlimited shapes in named categories, without a download."""

from viewgain.shapes._catalogue import CATEGORIES as CATEGORIES
from viewgain.shapes._catalogue import Category as Category
from viewgain.shapes._catalogue import procedural as procedural
from viewgain.shapes._catalogue import random_object as random_object
