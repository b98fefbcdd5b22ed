/* A joint of a member, as a user's stage gets it. Spaces and units: metres, radians, seconds, right-handed, +Y up, +Z front. */
typedef struct {
    float4 translation;   /* after Pose, to read and write: local, x y z 0 */
    float4 rotation;      /* after Pose, to read and write: local, a quaternion x y z w; brought to length 1 */
    float4 scale;         /* after Pose, to read and write: local, x y z 0 */
    float4 row0;          /* after Transform, to read and write: model_from_joint as three rows; */
    float4 row1;          /*     the fourth number of each is the translation */
    float4 row2;
    float4 place;         /* where the member stands in the world: x y z, and its size */
    float4 facing;        /* sine and cosine of its heading about +Y, 0 0: (0, 1) faces +Z, (1, 0) faces +X */
    float4 values;        /* the member's own, as given to use_stage */
    float parameters[16]; /* the stage's, as given to set_stage_parameters; 0 past those */
    ulong ticks;          /* since the crowd began, 705,600 a second: exact for all time; see stage_phase */
    float elapsed_secs;   /* since the frame before */
    uint joint;           /* in level order */
    uint member;          /* the number of the member: that of no other while it is there */
} StageJoint;
