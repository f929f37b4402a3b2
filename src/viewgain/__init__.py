"""viewgain: how big is the box, how sure are we, and where should the depth camera move next?"""
