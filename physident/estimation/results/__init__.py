"""What an estimate answers: its prediction of a recording, its values as a table and as a figure.

``predictions`` holds filtered torques beside the measured ones, ``values`` the parameters as a table and as a figure.
"""
